"""A headless Firefox, led by the protocol that it speaks by itself (WebDriver BiDi)."""

import json
import subprocess
from itertools import count
from time import monotonic, sleep

from selenium.webdriver.common.utils import free_port
from websocket import WebSocketException, create_connection


class Firefox:
    """One page: `get`, `execute_script` as of selenium's browsers, and the console's words."""

    def __init__(self, program, profile):
        port = free_port()
        command = [program, "--headless", "--no-remote", "--profile", str(profile)]
        self.process = subprocess.Popen(
            [*command, "--remote-debugging-port", str(port)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={"HOME": str(profile), "PATH": "/usr/bin:/bin"},
        )
        self.socket = self.connected(f"ws://127.0.0.1:{port}/session")
        self.numbers, self.words = count(1), []
        self.ask("session.new", {"capabilities": {}})
        self.ask("session.subscribe", {"events": ["log.entryAdded"]})
        self.page = self.ask("browsingContext.getTree", {})["contexts"][0]["context"]

    @staticmethod
    def connected(address, seconds=60):
        """A socket, as soon as the browser listens."""
        end = monotonic() + seconds
        while True:
            try:
                return create_connection(address, timeout=60, suppress_origin=True)
            except (OSError, WebSocketException):
                if monotonic() > end:
                    raise
                sleep(0.2)

    def ask(self, method, params):
        """The result of a command; what the console says meanwhile is kept."""
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self.socket.recv())
            if answer.get("method") == "log.entryAdded":
                self.words.append(answer["params"])
            elif answer.get("id") == number:
                assert answer["type"] == "success", answer
                return answer["result"]

    def get(self, address):
        """Open an address and wait until it is loaded."""
        self.ask("browsingContext.navigate", {"context": self.page, "url": address, "wait": "complete"})

    def execute_script(self, script):
        """What a script returns: a text, a number, or a truth."""
        wanted = {"expression": f"(() => {{ {script} }})()", "target": {"context": self.page}}
        answer = self.ask("script.evaluate", wanted | {"awaitPromise": False})
        assert answer["type"] == "success", answer
        return answer["result"].get("value")

    def get_log(self, _):
        """Everything that the console has said."""
        return self.words

    def quit(self):
        """End the browser that was begun here."""
        self.socket.close()
        self.process.terminate()
        self.process.wait(timeout=60)
