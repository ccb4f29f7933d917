"""How nodes find each other: domain, range, multicast."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
import socket
import struct

from blob_tracker.commands.doctor.finding import error, Finding, ok, warn

RANGES = ('SUBNET', 'LOCALHOST', 'OFF', 'SYSTEM_DEFAULT')
LARGEST_DOMAIN = 232
PORT_BASE, PORTS = 7400, 250  # of domain 0, and of each domain (DDSI-RTPS 2.2, 9.6.1.1)
USED = 110  # of them, by the first fifty participants
EPHEMERAL = Path('/proc/sys/net/ipv4/ip_local_port_range')
GROUP = '239.255.0.1'  # that of DDS' discovery
ANSWER = 1.0  # s for a datagram to come back


def check_domain(
    environment: Mapping[str, str], ephemeral: Path = EPHEMERAL
) -> Iterator[Finding]:
    """
    Look at ROS_DOMAIN_ID.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    ephemeral : Path
        The file in which the kernel tells the ports that it gives to whoever asks for any.

    """
    text = environment.get('ROS_DOMAIN_ID', '') or '0'
    if not text.isdecimal() or int(text) > LARGEST_DOMAIN:
        yield error(
            'discovery',
            f'ROS_DOMAIN_ID is {text!r}; it must be an integer from 0 to {LARGEST_DOMAIN}, and no '
            'node can start',
            'the same for all that belong together',
            'export ROS_DOMAIN_ID=0',
        )
        return
    domain = int(text)
    first = PORT_BASE + PORTS * domain
    try:
        low, high = (int(word) for word in ephemeral.read_text().split())
    except (OSError, ValueError):
        low, high = 32768, 60999  # as Linux comes
    if low < first + USED and first <= high:
        yield warn(
            'discovery',
            f'ROS_DOMAIN_ID {domain} has the UDP ports {first} to {first + USED - 1}, of which '
            f'the kernel gives {low} to {high} to other programs: now and then a node will find '
            'its port taken',
            'take one from 1 to 101, for all',
            'export ROS_DOMAIN_ID=42',
        )
        return
    yield ok('discovery', f'domain {domain}')


def check_range(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Look at who may find the nodes."""
    reach = environment.get('ROS_AUTOMATIC_DISCOVERY_RANGE', '')
    alone = environment.get('ROS_LOCALHOST_ONLY', '')
    if alone == '1':
        yield warn(
            'discovery',
            'ROS_LOCALHOST_ONLY is set, which Jazzy still honours, with a warning from each node, '
            'and for which it ignores ROS_AUTOMATIC_DISCOVERY_RANGE',
            'say the same as of now',
            'unset ROS_LOCALHOST_ONLY; export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST',
        )
    elif reach and reach not in RANGES:
        yield warn(
            'discovery',
            f'ROS_AUTOMATIC_DISCOVERY_RANGE is {reach!r}, which is none of {", ".join(RANGES)}: '
            'nodes take it for LOCALHOST',
            'for one machine alone',
            'export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST',
        )
    elif reach == 'OFF':
        yield error(
            'discovery',
            'ROS_AUTOMATIC_DISCOVERY_RANGE is OFF: not even nodes of one machine find each other',
            'for one machine alone',
            'export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST',
        )
    elif reach == 'LOCALHOST':
        yield ok('discovery', 'this machine alone (ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST)')
    else:
        yield ok(
            'discovery', f'{reach or "SUBNET"}: all machines of the network with the same domain'
        )


def multicast_returns() -> None:
    """
    Send a datagram to the group of DDS' discovery and receive it.

    Raises
    ------
    OSError
        It cannot be sent, or does not come back (TimeoutError).

    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(('', 0))
        everywhere = struct.pack('=4sl', socket.inet_aton(GROUP), socket.INADDR_ANY)
        listener.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, everywhere)
        listener.settimeout(ANSWER)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)  # not on the wire
            sender.sendto(b'blob_tracker doctor', (GROUP, listener.getsockname()[1]))
        listener.recv(64)


def check_multicast(
    environment: Mapping[str, str], returns: Callable[[], None] = multicast_returns
) -> Iterator[Finding]:
    """
    Try what discovery over a network needs.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    returns : callable
        Sends and receives a datagram; raises OSError where that fails.

    """
    reach = environment.get('ROS_AUTOMATIC_DISCOVERY_RANGE', '')
    alone = environment.get('ROS_LOCALHOST_ONLY') == '1'
    if alone or reach not in ('', 'SUBNET', 'SYSTEM_DEFAULT'):
        return  # nodes of one machine find each other without it
    try:
        returns()
    except OSError as fault:
        why = 'does not come back' if isinstance(fault, TimeoutError) else f'fails: {fault}'
        yield warn(
            'multicast',
            f'a datagram to {GROUP} {why}: nodes do not find each other over the network; there '
            'is none, or a firewall is in the way',
            'let it through (sudo ufw allow in proto udp to 224.0.0.0/4), or stay on this machine',
            'export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST',
        )
        return
    yield ok('multicast', f'a datagram to {GROUP} comes back')
