"""Tokens and encryption."""

from __future__ import annotations

import hashlib
import ssl
from collections.abc import Iterator
from pathlib import Path

import pytest

from photonfarm import Farm, FarmError, LocalFarm

from .scenes import SKY

ADMIN_TOKEN = "an-admin-token-of-more-than-32-letters"


@pytest.fixture(scope="module")
def guarded(program: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Farm]:
    """A coordinator with users."""
    file = tmp_path_factory.mktemp("tokens") / "admin"
    file.write_text(ADMIN_TOKEN)
    options = ["--admin-token-file", str(file)]
    with LocalFarm(workers=1, threads=1, program=program, token=ADMIN_TOKEN, options=options) as farm:
        yield farm


def test_without_a_token_and_with_a_wrong_one(guarded: Farm) -> None:
    for token, kind in [("", "no-token"), ("x" * 40, "unknown-token")]:
        with Farm(guarded.connection.address, token) as stranger, pytest.raises(FarmError) as error:
            stranger.jobs()
        assert (error.value.status, error.value.kind) == (401, kind)
        assert error.value.remedy


def test_who_may_only_look_makes_no_jobs(guarded: Farm) -> None:
    token = guarded.call("POST", "/v1/users", {"name": "viola", "role": "viewer"})["token"]["secret"]
    job = guarded.submit(SKY, stop={"passes": 1}, wait=60)
    with Farm(guarded.connection.address, token) as viewer:
        assert viewer.me().user == "viola"
        assert viewer.job(job.id).picture().shape == (16, 24, 3)
        with pytest.raises(FarmError) as error:
            viewer.submit(SKY)
    assert (error.value.status, error.value.kind) == (403, "not-allowed")


def test_jobs_of_others_are_theirs(guarded: Farm) -> None:
    token = guarded.call("POST", "/v1/users", {"name": "ben", "role": "artist"})["token"]["secret"]
    job = guarded.submit(SKY, stop={"passes": 1}, wait=60)
    with Farm(guarded.connection.address, token) as ben, pytest.raises(FarmError) as error:
        ben.job(job.id).delete()
    assert (error.value.status, error.value.kind) == (403, "not-yours")
    assert job.status().owner == "operator"


def test_the_environment_is_asked(guarded: Farm, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PHOTONFARM_URL", guarded.connection.address)
    monkeypatch.setenv("PHOTONFARM_TOKEN", ADMIN_TOKEN)
    with Farm() as farm:
        assert farm.me().user == "operator"
    (tmp_path / "token").write_text("y" * 40 + "\n")
    monkeypatch.setenv("PHOTONFARM_TOKEN_FILE", str(tmp_path / "token"))
    with Farm() as farm, pytest.raises(FarmError) as error:
        farm.me()
    assert error.value.kind == "unknown-token"


def test_certificates_are_checked(program: Path, tmp_path: Path) -> None:
    with LocalFarm(workers=1, threads=1, program=program, data=tmp_path, options=["--tls", "auto"]) as local:
        address = local.connection.address.replace("127.0.0.1", "localhost")
        assert address.startswith("https://")
        certificate = tmp_path / "tls/certificate.pem"
        fingerprint = hashlib.sha256(ssl.PEM_cert_to_DER_cert(certificate.read_text())).hexdigest()
        with Farm(address, "", ca=certificate) as farm:
            assert farm.submit(SKY, stop={"passes": 1}).wait().state == "done"
        with Farm(address, "", fingerprint="sha256:" + fingerprint) as farm:
            assert len(farm.jobs()) == 1
        with Farm(address, "", fingerprint="sha256:" + "0" * 64) as farm, pytest.raises(FarmError, match="not the one of the fingerprint"):
            farm.jobs()
        with Farm(address, "") as farm, pytest.raises(FarmError, match="not trusted here"):
            farm.jobs()


def test_trust_that_would_not_count_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FarmError, match="write https"):
        Farm("http://127.0.0.1:8080", "", ca=tmp_path / "ca.pem")
    with pytest.raises(FarmError, match="no fingerprint"):
        Farm("https://127.0.0.1:8080", "", fingerprint="sha256:12")
    with pytest.raises(FarmError, match="give one of them"):
        Farm("https://127.0.0.1:8080", "", fingerprint="sha256:" + "0" * 64, ca=tmp_path / "ca.pem")
