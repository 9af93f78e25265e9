"""Names that would lead out of a folder, or that no file can have."""

UNFIT = (
    *("..", "../../x", "/tmp/x", "a/b", "a\\b", "..\\..\\x", "C:\\x", "c:x"),
    *(".", ".hidden", "-rf", "--out=x", " a", "a ", "a.", "~/../x", "./x"),
    *("a\0b", "a\nb", "a\rb", "a\tb", "a\x1b[2J", "\x7f", "\u202etxt.a"),
    *("CON", "nul", "com1.txt", "LPT9", "a*", "a?", 'a"b', "a<b", "a|b"),
    *("x" * 300, "\U00020000" * 60, "\uff0e\uff0e\uff0fx", "a\uff0fb"),
    *("\u2024.", "a\u200bb", "a\u2028b", "\ufeffa", "https://a/b"),
)

# Odd, but harmless.
FIT = (
    *("a", "a b", "Walk-1.2", "a..b", "100 %", "Conrad"),
    *("\u8d70\u5eca", "m\u00b2"),
)
