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

"""The SROS 2 policy grants what the nodes do, no more and no less."""

import functools
import xml.etree.ElementTree as ElementTree

import pytest
from node_flight import NODES
from node_harness import Nodes
from paced_link import LINK
from processes import wait_for

from uav_tracking_mpc.launch.supervisor import own_domain
from uav_tracking_mpc.settings.configuration import configuration_folder

POLICY = configuration_folder() / "security" / "uav_tracking.policy.xml"
KINDS = {
    ("topics", "publish"): "get_publisher_names_and_types_by_node",
    ("topics", "subscribe"): "get_subscriber_names_and_types_by_node",
    ("services", "reply"): "get_service_names_and_types_by_node",
    ("services", "request"): "get_client_names_and_types_by_node",
}


def granted(profile, element, attribute):
    """Absolute names that a profile allows."""
    node = profile.get("node")
    names = set()
    for group in profile.findall(element):
        if group.get(attribute) == "ALLOW":
            for entry in group:
                name = entry.text.strip().replace("~", f"/{node}")
                names.add(name if name.startswith("/") else f"/{name}")
    return names


@pytest.fixture(scope="module")
def profiles():
    root = ElementTree.parse(POLICY).getroot()
    assert root.tag == "policy" and root.get("version") == "0.2.0"
    found = {}
    for enclave in root.findall("enclaves/enclave"):
        (profile,) = enclave.findall("profiles/profile")
        assert enclave.get("path") == f"/uav_tracking/{profile.get('node')}"
        assert profile.get("ns") == "/"
        found[profile.get("node")] = profile
    return found


def asked(nodes):
    """What the graph says of each node."""
    return {
        (kind, node.get_name()): {name for name, _ in getattr(node, question)(node.get_name(), "/")}
        for node in nodes
        for kind, question in KINDS.items()
    }


@pytest.fixture(scope="module")
def graph():
    """What each node does: kind and node to names; every clock driven and followed.

    In a domain of its own: by a node's name the graph finds any that another file left there.
    """
    with own_domain(None) as domain:
        nodes = Nodes(domain_id=domain)
        found = told(nodes)
        nodes.end()
    return found


def told(nodes):
    """What the graph says once it knows the nodes."""
    nodes.add(NODES["uav_simulator"], publish_clock=True)
    nodes.add(NODES["target_publisher"], use_sim_time=True)
    controller = nodes.add(NODES["nmpc_controller"], use_sim_time=True)
    nodes.add(NODES["autopilot_link"], link=LINK, connection="nobody", target_system=2)
    # The graph learns of endpoints a moment after they are made.
    sends = functools.partial(controller.get_publisher_names_and_types_by_node, "nmpc_controller")
    assert wait_for(lambda: "/uav/command" in dict(sends("/")))
    found = asked(nodes.made)
    # The simulator hears /clock when another drives it.
    follower = nodes.add(NODES["uav_simulator"], use_sim_time=True)
    hears = follower.get_subscriber_names_and_types_by_node("uav_simulator", "/")
    found[("topics", "subscribe"), "uav_simulator"] |= {name for name, _ in hears}
    for node in ("uav_simulator", "autopilot_link"):  # where tf2_msgs is installed
        found[("topics", "publish"), node] |= {"/tf", "/tf_static"}
    return found


def test_there_is_an_enclave_for_each_node(profiles):
    assert set(profiles) == set(NODES)


@pytest.mark.nodes
@pytest.mark.parametrize("kind", KINDS, ids=" ".join)
@pytest.mark.parametrize("node", NODES)
def test_the_policy_grants_exactly_what_the_node_does(profiles, graph, node, kind):
    assert granted(profiles[node], *kind) == graph[kind, node]


def test_nothing_is_granted_by_pattern_or_denied(profiles):
    text = POLICY.read_text()
    assert "*" not in text
    assert "DENY" not in text
