"""The base of the problems."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from ..errors import InvalidProblem
from .description import Description
from .grades import Grade, changes_of_grade, grade, warn_of_contradictions, with_grade
from .inputs import Inputs
from .paths import Faults

__all__ = ["Problem", "only_in"]


def only_in(kind: str, *names: str) -> dict[str, str]:
    """Return entries of :attr:`Problem.counterparts`: fields that only another kind has."""
    return dict.fromkeys(names, f"only a {kind} has it")


class Problem(Description):
    """Base class of the problems.

    Files identify the kind of a problem by the names of its fields.

    Attributes
    ----------
    tables : mapping of str to tuple of str
        Fields that a case file groups in a table, by the name of the table.
    graded : tuple of str
        Fields that ``grade = "newsprint"`` supplies.
    counterparts : mapping of str to str
        Name of a field of another kind -> what a problem of this kind has in its place, for the
        message that rejects it.

    Examples
    --------
    >>> import woundon as wo
    >>> isinstance(wo.NipProblem.example(), wo.Problem)
    True
    """

    tables: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    graded: ClassVar[tuple[str, ...]] = ()
    counterparts: ClassVar[Mapping[str, str]] = {}

    def __init__(self, /, **fields: Any) -> None:
        super().__init__(**fields)
        if "grade" in fields:
            self._set_grade(grade(fields["grade"]))

    @property
    def named_grade(self) -> Grade | None:
        """The grade that the problem was created with; None without one."""
        return self.__dict__.get("_grade")

    def _set_grade(self, named_grade: Grade) -> None:
        """Keep the grade; in ``__dict__``, because fields of a description cannot be set."""
        self.__dict__["_grade"] = named_grade
        warn_of_contradictions(named_grade, self)

    @classmethod
    def _fields_of(cls, inputs: Inputs, faults: Faults) -> dict[str, Any]:
        """Return the values by field, completed by those of a grade."""
        if "grade" in inputs.fields:
            inputs.fields = with_grade(cls, inputs.fields, faults)
        return super()._fields_of(inputs, faults)

    def replace(self, /, **changes: Any) -> Self:
        """Return a variant with some fields changed; see :meth:`.Description.replace`.

        A ``grade`` replaces all fields that it supplies, except those that are changed with it.

        >>> import woundon as wo
        >>> nip = wo.NipProblem.example().replace(grade="lwc", roll_friction=0.25)
        >>> nip.web == wo.grade("lwc").web(), nip.roll_friction
        (True, 0.25)

        Raises
        ------
        InvalidProblem
            If a name does not exist or the variant is not admissible.
        """
        if "grade" not in changes:
            variant = super().replace(**changes)
            if self.named_grade is not None:
                variant.__dict__["_grade"] = self.named_grade
            return variant
        if not self.graded:
            text = f"a {type(self).__name__} has no web; must be left out"
            raise InvalidProblem.at("grade", text)
        new_grade = grade(changes.pop("grade"))
        variant = super().replace(**{**changes_of_grade(new_grade, self, changes), **changes})
        variant._set_grade(new_grade)
        return variant

    @property
    def input_warnings(self) -> tuple[str, ...]:
        """Inputs that have no effect or contradict each other, as sentences."""
        return ()

    @property
    def unused(self) -> tuple[str, ...]:
        """Dotted names of fields, or of descriptions, on which nothing depends in this case."""
        return ()

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions of the model for this case, as sentences."""
        return ()

    @classmethod
    def example(cls) -> Self:
        """Return an example, which ``woundon new`` writes."""
        raise NotImplementedError(f"{cls.__name__} has no example")
