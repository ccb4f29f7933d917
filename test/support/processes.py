"""Real nodes in processes of their own, and a node of the test's beside them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from ament_index_python.packages import get_package_prefix
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import GetParameters, SetParameters
import rclpy
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from support.slowness import slowness

# What is waited for comes or hangs: a limit costs nothing where it comes, and is long. All of them
# are stretched by `slowness`, which lags by a minute where others begin to work.
EXIT = 20.0  # s that a process has to end
PATIENCE = 60.0  # s for a process to start and be discovered, and for all that it does then
ANSWER = 5.0  # s that the answer of a service has until it is asked once more


def executable(name: str) -> Path:
    """Return the executable that `ros2 run blob_tracker <name>` starts."""
    return Path(get_package_prefix('blob_tracker')) / 'lib' / 'blob_tracker' / name


class Process:
    """A running command with its output; ends with the block that it is used in."""

    def __init__(self, command: list[str], domain: int) -> None:
        self._popen = subprocess.Popen(
            command,
            env=dict(
                os.environ,
                ROS_DOMAIN_ID=str(domain),
                PYTHONUNBUFFERED='1',
            ),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,  # what it starts in turn can be ended with it
        )
        self.output = ''

    @property
    def running(self) -> bool:
        """Tell whether the process lives."""
        return self._popen.poll() is None

    def libraries(self) -> str:
        """Return the names of the libraries that the process has loaded so far."""
        return Path(f'/proc/{self._popen.pid}/maps').read_text()

    def memory(self) -> float:
        """Return the resident memory, MB."""
        return self._status('VmRSS') / 1024.0

    def own_memory(self) -> float:
        """Return the memory that no other process shares (USS), MB."""
        lines = Path(f'/proc/{self._popen.pid}/smaps_rollup').read_text().splitlines()
        private = [line.split()[1] for line in lines if line.startswith('Private_')]
        return sum(map(int, private)) / 1024.0

    def threads(self) -> int:
        """Return the count of threads."""
        return self._status('Threads')

    def files(self) -> int:
        """Return the count of open files."""
        return len(list(Path(f'/proc/{self._popen.pid}/fd').iterdir()))

    def _status(self, name: str) -> int:
        """Return a number of proc(5), status."""
        for line in Path(f'/proc/{self._popen.pid}/status').read_text().splitlines():
            key, _, value = line.partition(':')
            if key == name:
                return int(value.split()[0])
        raise KeyError(name)

    def send(self, number: int) -> None:
        """Send a signal."""
        self._popen.send_signal(number)

    def end(self, number: int = signal.SIGINT, timeout: float = EXIT) -> int:
        """Send a signal, wait for the end, and return the exit code."""
        if self.running:
            self.send(number)
        return self.wait(timeout)

    def ctrl_c(self, timeout: float = EXIT) -> int:
        """Interrupt all that it has started, as a terminal does; `ros2 run` relies on that."""
        if self.running:
            os.killpg(self._popen.pid, signal.SIGINT)
        return self.wait(timeout)

    def wait(self, timeout: float = PATIENCE) -> int:
        """Wait for the end and return the exit code; the output is in `output`."""
        try:
            self.output = self._popen.communicate(timeout=timeout * slowness())[0]
        except ValueError:
            pass  # waited for before
        return self._popen.returncode

    def __enter__(self) -> Process:
        return self

    def __exit__(self, *error: object) -> None:
        try:
            self.end()
        except subprocess.TimeoutExpired:
            with suppress(ProcessLookupError):  # all of them have ended meanwhile
                os.killpg(self._popen.pid, signal.SIGKILL)  # with what it has started
            self.wait()
            raise


def start(name: str, domain: int, *arguments: str, **parameters: object) -> Process:
    """Start a node of the package with parameters (`noise__gain` stands for noise.gain)."""
    command = [str(executable(name)), '--ros-args', *arguments]
    for key, value in parameters.items():
        command += ['-p', f'{key.replace("__", ".")}:={value}']
    return Process(command, domain)


def start_replay(bag: Path, domain: int, *arguments: str) -> Process:
    """Start `python3 -m blob_tracker replay`."""
    return Process([sys.executable, '-m', 'blob_tracker', 'replay', str(bag), *arguments], domain)


class Probe(Node):
    """A node of the test's own that records topics and publishes."""

    def __init__(self, context: Context, namespace: str) -> None:
        super().__init__('probe', context=context, namespace=namespace)
        self.received: dict[str, list[Any]] = {}
        self._callers: dict[str, Client] = {}
        self._spinner = SingleThreadedExecutor(context=context)
        self._spinner.add_node(self)

    def record(self, kind: type, topic: str, qos: Any = 100) -> list[Any]:
        """Subscribe to a topic; its messages go to the list that is returned."""
        messages: list[Any] = []
        self.received[topic] = messages
        self.create_subscription(kind, topic, messages.append, qos)
        return messages

    def call(self, kind: Any, service: str, request: Any) -> Any:
        """Wait for a service, call it and return its answer."""
        if service not in self._callers:
            self._callers[service] = self.create_client(kind, service)
        return self._ask(self._callers[service], request)

    def meet(self, *nodes: str) -> None:
        """
        Wait until nodes know the publishers and subscriptions that this one has made so far.

        Discovery has two ends: of a subscription that a publisher knows the publisher need not be
        known, and what best effort sends then is lost. What a process has made is announced in
        order: who answers a client knows all that was made before the client.
        """
        for node in nodes:
            client = self.create_client(GetParameters, f'{node}/get_parameters')
            self._ask(client, GetParameters.Request())
            self.destroy_client(client)

    def _ask(self, client: Client, request: Any) -> Any:
        """Wait for the service of a client, call it and return its answer."""
        self.spin_until(client.service_is_ready)
        # It is ready when it hears; that its answer finds the way back is not known, and an answer
        # without one is lost.
        answers: list[Any] = []
        again = 0.0

        def answered() -> bool:
            nonlocal again
            if time.monotonic() >= again:
                future = client.call_async(request)
                future.add_done_callback(lambda done: answers.append(done.result()))
                again = time.monotonic() + ANSWER * slowness()
            return bool(answers)

        self.spin_until(answered)
        return answers[0]

    def set_parameter(self, node: str, name: str, value: Any) -> SetParametersResult:
        """Set a parameter of a node and return whether and why not."""
        request = SetParameters.Request()
        request.parameters = [Parameter(name, value=value).to_parameter_msg()]
        return self.call(SetParameters, f'{node}/set_parameters', request).results[0]

    def spin(self, seconds: float) -> None:
        """Take what arrives in this time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._spinner.spin_once(timeout_sec=max(end - time.monotonic(), 0.0))

    def settle(self, seconds: float) -> None:
        """Take what is on its way, which arrives in this time on a quiet machine."""
        self.spin(seconds * slowness())

    def spin_until(self, done: Callable[[], object], timeout: float = PATIENCE) -> None:
        """Take what arrives until a condition holds; fail after the time-out."""
        began = time.monotonic()
        while not done():
            waited = time.monotonic() - began
            assert waited < timeout * slowness(), f'not within {waited:.0f} s'
            self._spinner.spin_once(timeout_sec=0.05)


@contextmanager
def probe(domain: int, namespace: str = '') -> Iterator[Probe]:
    """Make a probe in a domain."""
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    node = Probe(context, namespace)
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)
