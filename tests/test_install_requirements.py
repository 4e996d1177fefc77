"""pip's settings reach uv."""

from tools.install_requirements import pip_settings, uv_environment

LISTING = """\
:env:.cert='/env/ca.pem'
global.cert='/etc/ca.pem'
global.extra-index-url='https://one.example/simple\\nhttps://two.example/simple'
global.find-links='/a /b'
global.index-url='https://index.example/simple'
install.no-index='true'
list.format='columns'
"""


def test_later_sections_of_pip_override_earlier_ones() -> None:
    settings = pip_settings(LISTING)
    assert settings["cert"] == "/env/ca.pem"
    assert settings["no-index"] == "true"
    assert "format" not in settings


def test_uv_gets_what_pip_has() -> None:
    environment = uv_environment(pip_settings(LISTING), {})
    assert environment["UV_DEFAULT_INDEX"] == "https://index.example/simple"
    assert environment["UV_INDEX"] == "https://one.example/simple https://two.example/simple"
    assert environment["UV_FIND_LINKS"] == "/a,/b"
    assert environment["SSL_CERT_FILE"] == "/env/ca.pem"
    assert environment["UV_INDEX_STRATEGY"] == "unsafe-best-match"


def test_what_is_set_for_uv_stays() -> None:
    environment = uv_environment(
        pip_settings(LISTING), {"UV_DEFAULT_INDEX": "https://mine.example", "HOME": "/home/me"}
    )
    assert environment["UV_DEFAULT_INDEX"] == "https://mine.example"
    assert environment["HOME"] == "/home/me"


def test_a_plain_machine_names_no_index() -> None:
    environment = uv_environment(pip_settings(""), {})
    assert not {"UV_DEFAULT_INDEX", "UV_INDEX", "UV_FIND_LINKS", "SSL_CERT_FILE"} & set(environment)
