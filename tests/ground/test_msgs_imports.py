"""generated: what is found in the folder of pyros1.msgs, by whoever looks first."""

from __future__ import annotations

from pathlib import Path

from pyros1.ground.msgs_imports import GeneratedModules, MsgsFolderFinder


def test_folders_with_stubs_do_not_hide_generated_modules(tmp_path: Path) -> None:
    (tmp_path / "std_msgs").mkdir()
    (tmp_path / "std_msgs" / "__init__.pyi").touch()
    modules = GeneratedModules()
    finder = MsgsFolderFinder(str(tmp_path), modules)
    for name in ("pyros1.msgs.std_msgs", "pyros1.msgs.geometry_msgs"):
        spec = finder.find_spec(name)
        assert spec is not None and spec.loader is modules


def test_own_modules_are_found_as_in_any_folder(tmp_path: Path) -> None:
    (tmp_path / "base.py").touch()
    (tmp_path / "definitions").mkdir()
    finder = MsgsFolderFinder(str(tmp_path), GeneratedModules())
    module, folder = finder.find_spec("pyros1.msgs.base"), finder.find_spec("pyros1.msgs.definitions")
    assert module is not None and module.origin == str(tmp_path / "base.py")
    assert folder is not None and folder.loader is None
    assert list(folder.submodule_search_locations or ()) == [str(tmp_path / "definitions")]
    assert finder.find_spec("pyros1.msgs.text") is None
