"""A technician's file to a `Run` and back.

`read_table` takes what is really sent (interface: "Table of readings") and gives the same numbers
or a `DataError` with every fault: never a number in silence that could be another. `write_table`
gives the canonical form.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.tables.grid import together as together
    from scara_iso.tables.named_columns import (
        ColumnNames as ColumnNames,
        NamedColumns as NamedColumns,
        read_columns as read_columns,
    )
    from scara_iso.tables.poses import (
        Difference as Difference,
        PosePart as PosePart,
        converted as converted,
        differences as differences,
        merge as merge,
    )
    from scara_iso.tables.read import read_table as read_table
    from scara_iso.tables.scales import (
        corrected as corrected,
        stated_corrections as stated_corrections,
    )
    from scara_iso.tables.source import (
        Source as Source,
        decode_text as decode_text,
        read_bytes as read_bytes,
    )
    from scara_iso.tables.statements import normal_key as normal_key
    from scara_iso.tables.vocabulary.names import (
        is_axis as is_axis,
        length_in_mm as length_in_mm,
        pose_in as pose_in,
    )
    from scara_iso.tables.vocabulary.words import (
        FORMULA as FORMULA,
        in_english as in_english,
        is_of_axes as is_of_axes,
        is_of_corrections as is_of_corrections,
        listed as listed,
        names_a_limit as names_a_limit,
        parse_clean as parse_clean,
        quoted_whole as quoted_whole,
    )
    from scara_iso.tables.write import (
        PLAIN as PLAIN,
        OutputCell as OutputCell,
        SheetLocale as SheetLocale,
        find_locale as find_locale,
        published_table as published_table,
        write_rows as write_rows,
        write_table as write_table,
    )
else:
    __getattr__ = face(__name__)
