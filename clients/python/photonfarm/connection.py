"""Requests to a coordinator: encryption, tokens, and what is sent again."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from os import PathLike, fspath
from typing import Any, TypeVar
from urllib.parse import urlencode, urlsplit

import urllib3
from pydantic import BaseModel, ValidationError
from urllib3.exceptions import ConnectTimeoutError, HTTPError, NewConnectionError

from .errors import FarmError, found_here
from .generated.models import Problem

# Seconds between two attempts where the coordinator names no other time.
PAUSE = 0.5
CONNECT_PATIENCE = 10.0
ANSWER_PATIENCE = 120.0
# Nothing was done for an answer with one of these, so whatever was asked may be asked again.
REFUSED_FOR_NOW = (429, 503)

Model = TypeVar("Model", bound=BaseModel)


@dataclass(frozen=True)
class Request:
    """One request, as it may be sent several times."""

    method: str
    path: str
    query: Mapping[str, Any] = field(default_factory=dict)
    body: bytes | None = None
    headers: Mapping[str, str] = field(default_factory=dict)
    is_repeatable: bool = False
    """Whether two of them do no more than one."""
    patience: float = ANSWER_PATIENCE
    """Seconds of silence after which the connection counts as broken."""
    is_stream: bool = False

    def with_json(self, body: Any) -> Request:
        """The same with a body of JSON."""
        return replace(self, body=json.dumps(body).encode(), headers={**self.headers, "Content-Type": "application/json"})


class Connection:
    """Speaks to one coordinator, or to whichever of several leads."""

    def __init__(self, addresses: str, token: str | None, ca: str | PathLike[str] | None, fingerprint: str | None, patience: float) -> None:
        self.addresses = [checked_address(address) for address in addresses.split(",")]
        self._current = 0
        self._was_heard = False
        self._patience = patience
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        if (ca or fingerprint) and any(address.startswith("http:") for address in self.addresses):
            raise found_here("bad-address", f"{addresses} is not encrypted, but it is said whom to trust", "write https://")
        # No coordinator sends anybody elsewhere, and the token is for this one; a proxy would only be in the way of live events.
        self._pool = urllib3.PoolManager(maxsize=4, retries=False, **trust(ca, fingerprint))

    @property
    def address(self) -> str:
        """Where somebody answered last."""
        return self.addresses[self._current]

    def ask(self, model: type[Model], request: Request) -> Model:
        """The answer in its form."""
        return self.read(model, self.bytes(request))

    def read(self, model: type[Model], answer: str | bytes) -> Model:
        """JSON in its form. What a newer coordinator tells beside is passed over."""
        try:
            return model.model_validate_json(answer, extra="ignore")
        except ValidationError as problem:
            detail = f"{self.address} does not answer as a coordinator of this version ({problem})"
            raise found_here("not-a-coordinator", detail, "check the address and the versions") from None

    def bytes(self, request: Request) -> bytes:
        """The bytes of the answer."""
        return self.send(request).data

    def send(self, request: Request) -> urllib3.BaseHTTPResponse:
        """Sends a request until it is met, until it is refused for good, or until patience is over."""
        end = time.monotonic() + self._patience
        addresses_left = len(self.addresses)
        while True:
            try:
                answer = self._send_once(request)
                if answer.status < 300:
                    return answer
                error, may_repeat = told(answer), answer.status in REFUSED_FOR_NOW
            except HTTPError as broken:
                error = self._unreachable(broken)
                never_sent = isinstance(broken, (NewConnectionError, ConnectTimeoutError))
                # Where nobody was ever heard the address is wrong, and waiting does not help.
                may_repeat = (never_sent or request.is_repeatable) and (self._was_heard or addresses_left > 1)
            addresses_left -= 1
            pause = 0 if addresses_left > 0 else error.retry_after or PAUSE
            if not may_repeat or time.monotonic() + pause > end:
                raise error
            self._current = (self._current + 1) % len(self.addresses)
            time.sleep(pause)

    def _send_once(self, request: Request) -> urllib3.BaseHTTPResponse:
        query = {name: value for name, value in request.query.items() if value is not None}
        answer = self._pool.request(
            request.method,
            self.address + request.path + ("?" + urlencode(query) if query else ""),
            body=request.body,
            headers={**self._headers, **request.headers},
            timeout=urllib3.Timeout(connect=CONNECT_PATIENCE, read=request.patience),
            redirect=False,
            preload_content=not request.is_stream,
        )
        self._was_heard = True
        return answer

    def close(self) -> None:
        """Closes what is open."""
        self._pool.clear()

    def _unreachable(self, broken: HTTPError) -> FarmError:
        cause = str(broken)
        if "Fingerprints did not match" in cause:
            remedy = "its certificate is not the one of the fingerprint; compare with what the coordinator printed"
        elif "CERTIFICATE_VERIFY_FAILED" in cause:
            remedy = "its certificate is not trusted here; give the authority's file as ca, or the fingerprint that it printed"
        else:
            remedy = "start one with `photonfarm serve`, or give its address"
        return found_here("unreachable", f"no coordinator answers at {self.address} ({cause})", remedy)


def told(answer: urllib3.BaseHTTPResponse) -> FarmError:
    """The problem that an answer tells."""
    with suppress(ValidationError):
        return FarmError(Problem.model_validate_json(answer.data, extra="ignore"))
    remedy = "check that the address is that of a photonfarm coordinator"
    return found_here("not-a-coordinator", f"the coordinator answers {answer.status} {answer.reason or ''}".strip(), remedy, answer.status)


def trust(ca: str | PathLike[str] | None, fingerprint: str | None) -> dict[str, Any]:
    """Which certificates count: those of an authority, the one with a fingerprint, or those that this system trusts."""
    if fingerprint is not None:
        return {"cert_reqs": "CERT_NONE", "assert_fingerprint": checked_fingerprint(fingerprint)}
    return {"cert_reqs": "CERT_REQUIRED"} | ({"ca_certs": fspath(ca)} if ca is not None else {})


def checked_fingerprint(text: str) -> str:
    """The digits of a fingerprint."""
    digits = text.strip().lower().removeprefix("sha256:").replace(":", "")
    if len(digits) != 64 or not set(digits) <= set("0123456789abcdef"):
        raise found_here("bad-address", f"\"{text}\" is no fingerprint", "give sha256: and 64 hexadecimal digits, as the coordinator prints it")
    return digits


def checked_address(text: str) -> str:
    """The address of a coordinator without a slash at its end."""
    parts = urlsplit(text.strip())
    if parts.scheme not in ("http", "https") or not parts.hostname or parts.username is not None:
        # What stands before an @ may be a password.
        shown = text.rsplit("@", 1)[-1]
        raise found_here("bad-address", f"\"{shown}\" is not the address of a coordinator", "write http://HOST:PORT or https://HOST:PORT")
    return text.strip().rstrip("/")
