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

"""As much of ROS 2's ``launch`` and ``launch_ros`` as the launch files use, where there is none.

What a launch file would start comes out as plain objects. Where the real packages are installed,
they run the same files: see test/launch/test_launch_files.py.
"""

import sys
from contextlib import contextmanager
from types import ModuleType

import sources


class Context:
    """Values of the launch arguments by name."""

    def __init__(self):
        self.launch_configurations = {}


class LaunchDescription:
    def __init__(self, entities):
        self.entities = entities

    def visit(self, context):
        return self.entities


class LaunchConfiguration:
    def __init__(self, name):
        self.name = name

    def perform(self, context):
        return context.launch_configurations[self.name]


class DeclareLaunchArgument:
    def __init__(self, name, *, default_value, description, choices=None):
        self.name, self.default_value = name, default_value
        self.description, self.choices = description, choices

    def visit(self, context):
        default = self.default_value
        if isinstance(default, LaunchConfiguration):
            default = default.perform(context)
        value = context.launch_configurations.setdefault(self.name, default)
        assert isinstance(value, str), f"{self.name}: a launch argument is a text"
        if self.choices and value not in self.choices:
            raise RuntimeError(f"'{value}' is none of {self.choices}")
        return []


class OpaqueFunction:
    def __init__(self, *, function):
        self.function = function

    def visit(self, context):
        return self.function(context)


class PythonLaunchDescriptionSource:
    def __init__(self, path):
        self.path = path


class IncludeLaunchDescription:
    def __init__(self, source, *, launch_arguments=()):
        self.source, self.launch_arguments = source, dict(launch_arguments)

    def visit(self, context):
        # As the real one: set for the included file, and the file is evaluated in this context.
        context.launch_configurations.update(self.launch_arguments)
        return [loaded(self.source.path)]


class ExecuteProcess:
    def __init__(self, *, cmd, output):
        self.cmd = cmd

    def visit(self, context):
        return []


class Node:
    def __init__(
        self, *, package, executable, name, namespace="", parameters=(), arguments=(), output=""
    ):
        self.node_package, self.node_executable = package, executable
        self.files = [each for each in parameters if isinstance(each, str)]
        self.values = {
            k: v for each in parameters if isinstance(each, dict) for k, v in each.items()
        }
        self.arguments = list(arguments)
        self.node_name = "/" + "/".join(part for part in (namespace.strip("/"), name) if part)

    def visit(self, context):
        return []


MODULES = {
    "launch": [LaunchDescription],
    "launch.actions": [
        DeclareLaunchArgument,
        ExecuteProcess,
        IncludeLaunchDescription,
        OpaqueFunction,
    ],
    "launch.launch_description_sources": [PythonLaunchDescriptionSource],
    "launch.substitutions": [LaunchConfiguration],
    "launch_ros": [],
    "launch_ros.actions": [Node],
}


@contextmanager
def stand_in():
    """The stand-in under the names of the real packages."""
    before = {name: sys.modules.get(name) for name in MODULES}
    for name, classes in MODULES.items():
        sys.modules[name] = ModuleType(name)
        for kind in classes:
            setattr(sys.modules[name], kind.__name__, kind)
    try:
        yield
    finally:
        for name, module in before.items():
            sys.modules.pop(name)
            if module is not None:
                sys.modules[name] = module


def loaded(path):
    """Launch description of a file."""
    return sources.loaded(path, "launch_file").generate_launch_description()


def started(entity, context):
    """What a launch description starts, in order."""
    found = [entity] if isinstance(entity, Node | ExecuteProcess) else []
    for each in entity.visit(context) or []:
        found += started(each, context)
    return found
