from .grid import together as together
from .named_columns import (
    ColumnNames as ColumnNames,
    NamedColumns as NamedColumns,
    read_columns as read_columns,
)
from .poses import (
    Difference as Difference,
    PosePart as PosePart,
    converted as converted,
    differences as differences,
    merge as merge,
)
from .read import read_table as read_table
from .scales import (
    corrected as corrected,
    stated_corrections as stated_corrections,
)
from .source import (
    Source as Source,
    decode_text as decode_text,
    read_bytes as read_bytes,
)
from .statements import normal_key as normal_key
from .vocabulary.names import (
    is_axis as is_axis,
    length_in_mm as length_in_mm,
    pose_in as pose_in,
)
from .vocabulary.words import (
    FORMULA as FORMULA,
    in_english as in_english,
    is_of_axes as is_of_axes,
    is_of_corrections as is_of_corrections,
    listed as listed,
    names_a_limit as names_a_limit,
    parse_clean as parse_clean,
    quoted_whole as quoted_whole,
)
from .write import (
    PLAIN as PLAIN,
    OutputCell as OutputCell,
    SheetLocale as SheetLocale,
    find_locale as find_locale,
    published_table as published_table,
    write_rows as write_rows,
    write_table as write_table,
)
