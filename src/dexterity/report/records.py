"""Frozen dataclasses as JSON and back, exactly or not at all.

Floats keep every bit, NaN and the infinities included; arrays keep dtype and shape; tuples stay tuples.
A record carries a digest of its content, so that one that was damaged or edited is not read. What does
not have the type that its field declares is refused, never converted.
"""

import json
import math
from collections.abc import Callable
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin

import cattrs
import cattrs.v
import numpy as np

from dexterity.store import content_key

__all__ = ["from_json", "from_plain", "to_json", "to_plain"]

T = TypeVar("T")

_NOT_FINITE = ("nan", "inf", "-inf")


def to_json(value: object) -> str:
    """Write a dataclass as a JSON record.

    Parameters
    ----------
    value
        A dataclass of bool, int, float, str, None and numpy arrays of numbers, and of tuples, mappings
        with text as keys, and dataclasses of these.

    Raises
    ------
    TypeError
        If something within it is of a type that has no place in a record.
    """
    content = to_plain(value)
    return _dump({"digest": content_key(_dump(content)), "content": content})


def from_json(text: str | bytes, kind: type[T]) -> T:
    """Read a record that `to_json` wrote.

    Parameters
    ----------
    text
        The record; UTF-8 where it is bytes.
    kind
        The dataclass to make.

    Raises
    ------
    ValueError
        If the text is no record, is damaged, or does not fit the dataclass.
    """
    record = json.loads(text)
    if not isinstance(record, dict) or record.keys() != {"digest", "content"}:
        raise ValueError("a record has a digest and a content, and nothing else")
    if record["digest"] != content_key(_dump(record["content"])):
        raise ValueError("the record's content is not the one that its digest was made from")
    return from_plain(record["content"], kind)


def to_plain(value: object) -> Any:
    """Turn a dataclass into the mappings, lists, texts and numbers of JSON.

    An array becomes its dtype, its shape and the flat list of its values; a float that is not finite,
    for which JSON has no number, becomes a text.

    Raises
    ------
    TypeError
        If a field declared float holds something else, or an array something else than numbers.
    """
    return _CONVERTER.unstructure(value)


def from_plain(plain: object, kind: type[T]) -> T:
    """Make a dataclass from the mappings and lists of a JSON or TOML file.

    Parameters
    ----------
    plain
        Mappings, lists, texts, numbers and None.
    kind
        The dataclass to make.

    Raises
    ------
    ValueError
        If a field is missing, unknown or of another type than declared; the message names each.
    """
    try:
        return _CONVERTER.structure(plain, kind)
    except (cattrs.BaseValidationError, cattrs.StructureHandlerNotFoundError) as error:
        reasons = cattrs.transform_error(error, format_exception=_reason)
        raise ValueError("; ".join(reasons)) from error


def _reason(error: BaseException, kind: Any) -> str:
    return str(error) if isinstance(error, TypeError | ValueError) else cattrs.v.format_exception(error, kind)


def _dump(plain: object) -> str:
    return json.dumps(plain, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _float_to_plain(value: object) -> float | str:
    if isinstance(value, bool) or not isinstance(value, float | int | np.floating):
        raise TypeError(f"{value!r} is declared a float and is {type(value).__name__}")
    number = float(value)
    return number if math.isfinite(number) else repr(number)


def _float_from_plain(plain: Any, _: object) -> float:
    if type(plain) not in (float, int) and plain not in _NOT_FINITE:
        raise TypeError(f"{plain!r} is not a number")
    return float(plain)


def _exactly(kind: type[T]) -> Callable[[Any, object], T]:
    def from_plain(plain: Any, _: object) -> T:
        if type(plain) is not kind:
            raise TypeError(f"{plain!r} is not of type {kind.__name__}")
        return plain

    return from_plain


def _tuple_from_plain(plain: Any, kind: Any) -> tuple[Any, ...]:
    if not isinstance(plain, list):
        raise TypeError(f"{plain!r} is not a list")
    kinds = get_args(kind)
    if kinds[-1:] == (...,):
        kinds = (kinds[0],) * len(plain)
    if len(kinds) != len(plain):
        raise TypeError(f"{plain!r} has {len(plain)} values and is declared to have {len(kinds)}")
    return tuple(_CONVERTER.structure(item, item_kind) for item, item_kind in zip(plain, kinds, strict=True))


def _union_from_plain(plain: Any, kind: Any) -> Any:
    for member in get_args(kind):
        try:
            return None if plain is None and member is NoneType else _CONVERTER.structure(plain, member)
        except (cattrs.BaseValidationError, cattrs.StructureHandlerNotFoundError, TypeError):
            continue
    raise TypeError(f"{plain!r} is none of {kind}")


def _array_to_plain(array: np.ndarray) -> dict[str, Any]:
    if array.dtype.kind not in "biuf":
        raise TypeError(f"an array of dtype {array.dtype} has no place in a record")
    values = array.ravel().tolist()
    if array.dtype.kind == "f":
        values = [_float_to_plain(value) for value in values]
    return {"dtype": array.dtype.str, "shape": list(array.shape), "values": values}


def _array_from_plain(plain: Any, _: object) -> np.ndarray:
    return np.array(plain["values"], dtype=plain["dtype"]).reshape(plain["shape"])


def _is_array(kind: Any) -> bool:
    """Tell whether an annotation means an array: bare, with a dtype, or with jaxtyping's shape."""
    return getattr(kind, "array_type", get_origin(kind) or kind) is np.ndarray


def _has_origin(*origins: Any) -> Callable[[Any], bool]:
    return lambda kind: get_origin(kind) in origins


def _strict_converter() -> cattrs.Converter:
    converter = cattrs.Converter(forbid_extra_keys=True)
    converter.register_unstructure_hook(float, _float_to_plain)
    converter.register_structure_hook(float, _float_from_plain)
    for kind in (bool, int, str):
        converter.register_structure_hook(kind, _exactly(kind))
    converter.register_structure_hook_func(_has_origin(tuple), _tuple_from_plain)
    converter.register_structure_hook_func(_has_origin(Union, UnionType), _union_from_plain)
    converter.register_unstructure_hook_func(_is_array, _array_to_plain)
    converter.register_structure_hook_func(_is_array, _array_from_plain)
    return converter


_CONVERTER = _strict_converter()
