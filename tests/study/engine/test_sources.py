"""What names a source file: its code, and neither its words nor the version of Python that reads it."""

import ast

from dexterity_study.engine import sources

CODE = '''"""Words."""

def draw(seed):  # more words
    """Other words."""
    return [None, seed]
'''


def test_the_name_of_a_file_leaves_out_words_and_layout(tmp_path):
    first, second = tmp_path / "first.py", tmp_path / "second.py"
    first.write_text(CODE)
    second.write_text("def draw(\n    seed\n):\n    return [None, seed]\n")
    assert sources.fingerprint(first) == sources.fingerprint(second)
    second.write_text(CODE.replace("None", "1"))
    assert sources.fingerprint(first) != sources.fingerprint(second)


def test_the_name_of_a_file_is_the_same_for_versions_whose_functions_have_type_parameters(
    tmp_path, monkeypatch
):
    first, second = tmp_path / "first.py", tmp_path / "second.py"
    for file in (first, second):
        file.write_text(CODE)
    before = sources.fingerprint(first)
    monkeypatch.setattr(ast.FunctionDef, "_fields", (*ast.FunctionDef._fields, "type_params"))
    monkeypatch.setattr(ast.FunctionDef, "type_params", [], raising=False)
    assert sources.fingerprint(second) == before
