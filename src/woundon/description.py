"""The base of every description (material, body, problem): immutable, validated when made.

pydantic does the checking; this module turns its report into :class:`InvalidProblem` texts that
name the field, the value and the admissible range, and gives every description ``replace``.
"""

from __future__ import annotations

from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from .errors import InvalidProblem, NoSteadyState, did_you_mean

__all__ = ["Description"]

_RANGE_WORDS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}


class Description(BaseModel):
    """An immutable, validated description; unknown names and values out of range are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, **fields: Any) -> None:
        try:
            self.__pydantic_validator__.validate_python(fields, self_instance=self)
        except ValidationError as report:
            raise _readable(report, type(self)) from None

    def replace(self, **changes: Any) -> Self:
        """Return a variant with some fields changed; nested ones by dotted name.

        >>> problem.replace(nip_load=5e3, **{"web.thickness": 57e-6})  # doctest: +SKIP

        Raises
        ------
        InvalidProblem
            If a name does not exist or the variant is not admissible.
        """
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        nested: dict[str, dict[str, Any]] = {}
        for path, value in changes.items():
            head, _, rest = path.partition(".")
            if head not in fields:
                known = type(self).model_fields
                raise InvalidProblem([(path, f"no such field{did_you_mean(head, known)}")])
            if not rest:
                fields[head] = value
            else:
                nested.setdefault(head, {})[rest] = value
        for head, inner in nested.items():
            if not isinstance(fields[head], Description):
                raise InvalidProblem([(head, f"{head} has no fields of its own")])
            try:
                fields[head] = fields[head].replace(**inner)
            except InvalidProblem as fault:
                raise fault.under(head) from None
        return type(self)(**fields)


def _readable(report: ValidationError, model: type[BaseModel]) -> InvalidProblem:
    """Translate pydantic's report, innermost faults first, keeping the dotted path."""
    faults: list[tuple[str, str]] = []
    kind: type[InvalidProblem] = InvalidProblem
    for item in report.errors():
        path = ".".join(str(part) for part in item["loc"] if part not in _TAGS)
        inner = item.get("ctx", {}).get("error")
        if isinstance(inner, InvalidProblem):
            faults += inner.under(path).faults
            if isinstance(inner, NoSteadyState):
                kind = NoSteadyState
        else:
            faults.append((path, _text(item, model)))
    return kind(faults)


# the discriminator's tags appear in pydantic's paths but are no fields of ours
_TAGS = frozenset({"rigid", "half_plane", "cylinder", "orthotropic", "isotropic"})


def _text(item: Any, model: type[BaseModel]) -> str:
    value, kind, context = item["input"], item["type"], item.get("ctx", {})
    if kind == "extra_forbidden":
        return f"no such field{did_you_mean(str(item['loc'][-1]), model.model_fields)}"
    if kind == "missing":
        return "missing; it has no default"
    for key, sign in _RANGE_WORDS.items():
        if key in context:
            return f"{value!r} is out of range: must be {sign} {context[key]:g}{_unit(item, model)}"
    if kind == "finite_number":
        return f"{value!r} is not a finite number{_unit(item, model)}"
    if kind in ("float_type", "float_parsing"):
        return f"{value!r} is not a number{_unit(item, model)}"
    if kind == "union_tag_invalid":
        tags = [tag.strip(" '") for tag in context["expected_tags"].split(",")]
        return f"kind {context['tag']!r} is unknown{did_you_mean(str(context['tag']), tags)}"
    if kind == "union_tag_not_found":
        return f"{value!r} says no kind; give one of its kinds by 'kind = ...'"
    message = item["msg"].removeprefix("Value error, ")
    return message if kind == "value_error" else f"{value!r}: {message}"


def _unit(item: Any, model: type[BaseModel]) -> str:
    field = model.model_fields.get(str(item["loc"][-1])) if item["loc"] else None
    extra = field.json_schema_extra if field is not None else None
    unit = extra.get("unit") if isinstance(extra, dict) else None
    return f" [{unit}]" if unit and unit != "1" else ""
