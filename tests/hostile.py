"""What a file or a wire could say to do harm where it is shown: for the tests of every output."""

FORMULAS = (
    "=1+1",
    "+1+1",
    "-1+1",
    "@SUM(1)",
    "\t=1+1",
    "\r=1+1",
    " =1+1",
    "\n@SUM(1)",
    "=cmd|' /C calc'!A0",
    '=HYPERLINK("http://example.invalid","click")',
    'a";=1+1;"',
    "a,=1+1",
    "a;=1+1",
    "a\n=1+1",
)
"""Text that a spreadsheet could take for a formula."""

TEXTS = (
    *FORMULAS,
    "[red]x[/red]",
    "[/]",
    "[link=http://example.invalid]x[/link]",
    "<script>alert(1)</script>",
    "</style><img src=x onerror=alert(1)>",
    "]]><!--",
    "&lt;b&gt; &amp;",
    "a\x00b",
    "\x1b[2J\x1b[31mred\x1b]0;title\x07",
    "\x9b31m",
    "\u202eevil\u202c",
    "\u2066x\u2069",
    "one\ntwo\r\nthree\u2028four",
    "x" * 40_000,
    "\"quoted\" 'twice' `thrice`",
    "\ud800 and \udfff",
    "\ufffe\uffff",
    "{{ 7*7 }} {% raw %}",
    "| a | b |\n|---|---|",
    "$(reboot) `reboot` %PATH%",
    "../../etc/passwd",
)
"""Every hostile text."""
