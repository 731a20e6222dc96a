# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The documentation site: Sphinx with MyST and furo. `make docs` builds it, without a network."""

import sys
from pathlib import Path

from uav_tracking_mpc import __version__

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_extensions"))

project = "uav_tracking_mpc"
author = "uav_tracking_mpc maintainers"
copyright = "2026, uav_tracking_mpc maintainers"
release = version = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "command_help",
    "cross_references",
    "mathml",
    "spelling",
]
exclude_patterns = ["_build", "_extensions"]
nitpicky = True
nitpick_ignore_regex = [("py:obj", r".*\.[TN]")]  # variables of types have no page
toc_object_entries = False  # they would be copied into every page
suppress_warnings = ["ref.python"]  # a type in a signature whose name two classes have

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3

highlight_language = "bash"  # blocks of commands name none

html_theme = "furo"
html_title = "uav_tracking_mpc"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
html_search_scorer = str(HERE / "search_scorer.js")  # pages of text before attributes
html_copy_source = False
html_show_sphinx = False

autodoc_default_options = {"members": True}
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_attr_annotations = False  # the descriptions say units and shapes
