"""Whether the packages asked for are here: right, a different version, and one that is missing."""

from importlib import metadata

from mathpost.teaching.course import installed


def test_each_kind_of_need(tmp_path, capsys):
    pins = tmp_path / "environment.txt"
    here = metadata.version("numpy")
    pins.write_text(f"# pins\nnumpy=={here}\n", encoding="utf-8")
    installed.check(pins)
    assert capsys.readouterr().out == "all packages as asked for\n"
    pins.write_text("numpy==0.1\nno-such-package-here==1.0\nnumpy==0.2; python_version < '3'\n", encoding="utf-8")
    installed.check(pins)
    assert capsys.readouterr().out.splitlines() == [
        f"numpy==0.1 was asked for, {here} is here",
        "no-such-package-here==1.0 was asked for, none is here",
    ]
