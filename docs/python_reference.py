"""Makes the site's page of the Python reference: docs/python.md, with each name of its lists replaced by signature and docstring.

Docstrings are plain text in which `name : meaning` begins an entry; entries become definition lists.
"""

import importlib
import inspect
import re
import textwrap
import types

import gen_art as ga
from gen_art.registry import Registry

_ITEM = re.compile(r"^- `ga\.(\w+)`(?:: (.*(?:\n  .*)*))?$", re.M)
_ENTRY = re.compile(
    r"^([\w`][\w`(), .]*?)(?: : | {2,})(\S.*)$"
)  # "name : meaning", or names and meanings in two columns
WIDTH = 76  # characters of a line of code
_LISTED = ("forces", "interactions", "colliders", "emitters", "integrators")  # whose names have a page of their own
KEYS = {  # classes whose arguments are keys of a preset: their table there
    "Look": "look-of-a-system",
    "Sky": "sky",
    "Light": "light-of-the-preset-or-of-a-look",
    "Ground": "ground",
    "SurfaceLook": "look-of-a-collider",
}


def escaped(text: str) -> str:
    """Plain text as Markdown; what stands between backticks stays code."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(part if k % 2 else re.sub(r"([\\*_<>\[\]#|~])", r"\\\1", part) for k, part in enumerate(parts))


def term(names: str) -> str:
    """The names of an entry as code."""
    return names if "`" in names else f"`{names}`"


def markdown(doc: str) -> str:
    """A docstring as Markdown: paragraphs, entries as definition lists, indented examples as code."""
    blocks: list[list] = []  # [kind, text ...]; kinds: prose, entry, code
    begins = True
    for line in inspect.cleandoc(doc).splitlines():
        indented, text = line.startswith("    "), line.strip()
        last = blocks[-1][0] if blocks else None
        entry = None if indented else _ENTRY.match(line)
        if not text:
            if last == "code":
                blocks[-1].append("")
            begins = True
        elif indented and last == "code":
            blocks[-1].append(line[4:])
        elif indented and begins and last != "entry":
            blocks.append(["code", line[4:]])
            begins = False
        elif entry:
            blocks.append(["entry", entry[1], entry[2]])
            begins = False
        elif not begins and last == "entry" and (indented or text[0].islower()):
            blocks[-1][2] += " " + text
        elif begins or last != "prose":
            blocks.append(["prose", text])
            begins = False
        else:
            blocks[-1][1] += " " + text
    return "\n\n".join(_block(*block) for block in blocks)


def _block(kind: str, *text: str) -> str:
    if kind == "code":
        return "```python\n" + "\n".join(text).strip() + "\n```"
    if kind == "entry":
        return f"{term(text[0])}\n: {escaped(text[1])}"
    return escaped(text[0])


def call(name: str, function) -> str:
    """A call with the names and defaults of its arguments, wrapped; their types stand in the words below."""
    shown: list[str] = []
    star = False
    for p in inspect.signature(function).parameters.values():
        if p.name == "self" or p.name.startswith("_"):
            continue
        if p.kind is p.VAR_POSITIONAL or (p.kind is p.KEYWORD_ONLY and not star):
            star = True
            shown += [f"*{p.name}" if p.kind is p.VAR_POSITIONAL else "*"]
        if p.kind is p.VAR_KEYWORD:
            shown.append(f"**{p.name}")
        elif p.kind is not p.VAR_POSITIONAL:
            known = p.default is p.empty or isinstance(p.default, (int, float, str, tuple, type(None)))
            shown.append(p.name if p.default is p.empty else f"{p.name}={p.default!r}" if known else f"{p.name}=...")
    whole = f"{name}({', '.join(shown)})"
    return (
        whole if len(whole) <= WIDTH else textwrap.fill(whole, WIDTH, subsequent_indent="    ", break_long_words=False)
    )


def signature(name: str, value) -> str:
    """The first line of an entry, as one would write it."""
    if isinstance(value, Registry):
        return f'@ga.{name}("name")'
    if name in KEYS:
        return f"ga.{name}(key=value, ...)"
    if inspect.isclass(value) and (issubclass(value, Exception) or hasattr(value, "layout")):
        return f"class ga.{name}"
    return call(f"ga.{name}", value) if callable(value) else f"ga.{name}"


def method(owner: str, cls: type, name: str) -> str:
    """A method or a property of a class."""
    found = inspect.getattr_static(cls, name)
    doc = inspect.getdoc(found) or ""
    if isinstance(found, classmethod):
        owner = f"ga.{cls.__name__}"
    head = f"{owner}.{name}" if isinstance(found, property) else call(f"{owner}.{name}", getattr(cls, name))
    return f"```python\n{head}\n```\n\n{markdown(doc)}"


def listing(name: str) -> str:
    """Where the contents of a subpackage are described."""
    module = importlib.import_module(f"gen_art.{name}")
    words = escaped(inspect.cleandoc(module.__doc__ or ""))
    how = "Classes have the names of YAML in capitals without underscores: `self_gravity` is `SelfGravity`."
    if name == "integrators":
        how = "A system takes them by name: `integrator='rk4'`."
    return f"{words}\n\n{how} [forces.md](forces.md#{name}) lists all."


def entry(name: str, methods: list[str]) -> str:
    """The section of one public name."""
    value = getattr(ga, name)
    text = [f"### ga.{name}"]
    if isinstance(value, types.ModuleType):
        text += [listing(name) if name in _LISTED else "Taichi, as this package starts it: `from gen_art import ti`."]
        return "\n\n".join(text)
    text += [f"```python\n{signature(name, value)}\n```"]
    if isinstance(value, Registry):
        base = "PairLaw" if name == "interaction" else name.capitalize()
        text += [
            f"Class decorator: registers a subclass of [ga.{base}](#ga{base.lower()}) under this name, as which presets find it. "
            "Raises UsageError for a class without a docstring and for a name that is taken."
        ]
    else:
        text += [markdown(value.__doc__ or "")]
    if name in KEYS:
        text += [f"The arguments are the keys of YAML: [presets.md](presets.md#{KEYS[name]}) lists them."]
    if methods:
        owner = {"Simulation": "sim", "ParticleSystem": "system"}.get(name, name.lower())
        text += [f"**Methods and properties** of `{owner}`, a {name}:"]
        text += [method(owner, value, each) for each in methods]
    return "\n\n".join(text)


def page(text: str) -> str:
    """docs/python.md with entries in the place of names; public names that it does not list follow under `More`."""
    named = {match[1] for match in _ITEM.finditer(text)} | {"__version__"}
    more = [f"- `ga.{name}`" for name in ga.__all__ if name not in named]
    whole = text + ("\n## More\n\n" + "\n".join(more) + "\n" if more else "")
    return _ITEM.sub(lambda match: entry(match[1], re.findall(r"`(\w+)`", match[2] or "")) + "\n", whole)
