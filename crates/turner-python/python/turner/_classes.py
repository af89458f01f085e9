"""The classes of the scene format: one for each type of shape, material, light, …, made from the renderer's own schema."""

from __future__ import annotations

import json
import keyword

from . import _turner

#: The ending of a class's name, by family. Shapes have none: `Sphere`, but `PointLight`.
ENDINGS = {
    "shape": "",
    "camera": "Camera",
    "integrator": "Integrator",
    "material": "Material",
    "texture": "Texture",
    "medium": "Medium",
    "light": "Light",
    "": "",
}

#: Keys that all members of a family have besides their own.
LIGHT_KEYS = [
    ("name", '"text"', "A name, used in reports."),
    ("light_group", '"text"', "The light group of the light."),
    ("hidden", "true | false", "Whether it does not shine."),
    ("motion", "transform", "Motion blur: what moves the light while the shutter is open."),
]
CAMERA_KEYS = [("name", '"text"', "A name, for `[[view]]`.")]

#: Other names of keys, from NumPy's world and other programs.
ALIASES = {"mesh": {"vertices": "positions", "faces": "triangles", "uv": "uvs"}, "points": {"vertices": "positions"}}


def camel(name):
    """`rough-glass` and `rough_glass` as `RoughGlass`."""
    return "".join(part[:1].upper() + part[1:] for part in name.replace("-", "_").split("_"))


def near(name, valid):
    """`; did you mean "radius"?`, or nothing."""
    import difflib

    found = difflib.get_close_matches(name, valid, 1, 0.6)
    return f'; did you mean "{found[0]}"?' if found else ""


def argument(key):
    """A key as the name of an argument: `from_` for `from`, which is a word of Python."""
    return f"{key}_" if keyword.iskeyword(key) else key


class _Meta(type):
    """Makes the signature of a class from its keys, when it is asked for."""

    @property
    def __signature__(cls):
        import inspect

        parameters = [
            inspect.Parameter(argument(name), inspect.Parameter.KEYWORD_ONLY, default=key.get("shown", None))
            for name, key in cls._keys.items()
        ]
        return inspect.Signature(parameters)


class Description(metaclass=_Meta):
    """A part of a scene as plain values. Keys that are not given have their defaults."""

    _family = ""
    _type = None
    _keys: dict = {}
    _aliases: dict = {}
    __slots__ = ("_values",)

    def __init__(self, **keys):
        object.__setattr__(self, "_values", {})
        for key, value in keys.items():
            setattr(self, key, value)

    @classmethod
    def _key(cls, key):
        key = cls._aliases.get(key, key)
        if key not in cls._keys:
            valid = ", ".join(cls._keys) or "none"
            raise TypeError(f"{cls.__name__} has no key {key!r}{near(key, cls._keys)} valid: {valid}")
        return key

    def __setattr__(self, key, value):
        key = self._key(key)
        if value is None:
            self._values.pop(key, None)
        else:
            self._values[key] = value

    def __getattribute__(self, key):
        # A key comes before a function of the class with its name: `Camera.look_at` makes a camera, `look_at` is a key.
        if not key.startswith("_") and key in type(self)._keys:
            return self._values.get(key, type(self)._keys[key].get("value"))
        return object.__getattribute__(self, key)

    def __getattr__(self, key):
        if key.startswith("_"):
            raise AttributeError(key)
        key = self._aliases.get(key, key)
        if key not in self._keys:
            raise AttributeError(f"{type(self).__name__} has no key {key!r}{near(key, self._keys)}")
        return self._values.get(key, self._keys[key].get("value"))

    def copy(self, **changes):
        """The same with other values for some keys."""
        return type(self)(**{**self._values, **changes})

    def _plain_(self):
        head = {} if self._type is None else {"type": self._type}
        return {**head, **self._values}

    def __eq__(self, other):
        return type(self) is type(other) and self._values == other._values

    __hash__ = None

    def __repr__(self):
        inner = ", ".join(f"{key}={_short(value)}" for key, value in self._values.items())
        return f"{type(self).__name__}({inner})"

    def __reduce__(self):
        return (_rebuilt, (type(self).__name__, self._values))

    def __dir__(self):
        return [*object.__dir__(self), *self._keys]


def _rebuilt(name, values):
    return classes()[name](**values)


def _short(value):
    shape = getattr(value, "shape", None)
    if shape:
        return f"<array {'x'.join(map(str, shape))} {value.dtype}>"
    text = repr(value)
    return text if len(text) < 80 else text[:77] + "..."


def _value(text):
    """The default of a key as a value of Python; None if it is none."""
    if text is None:
        return None
    try:
        return json.loads(text)
    except ValueError:
        return None


def _doc(entry, keys):
    lines = [entry["doc"], "", "Keys:"]
    for name, key in keys.items():
        default = f", default {key['shown']}" if key.get("shown") not in (None, "none") else ""
        bounds = f", {key['range']}" if key.get("range") else ""
        lines.append(f"    {name} ({key['kind']}{bounds}{default}): {key['doc']}")
        lines += [f"        {word!r}: {meaning}" for word, meaning in key.get("words", ())]
    return "\n".join(lines)


def _with(keys, more):
    for name, kind, doc in more:
        keys.setdefault(name, {"name": name, "kind": kind, "doc": doc, "shown": None, "value": None})


_made: dict | None = None


def classes():
    """All classes by their names."""
    global _made
    if _made is None:
        _made = _make(_turner.schema())
    return _made


def _make(schema):
    from ._cameras import Camera

    bases = {
        family: type(family.capitalize(), (Description,), {"_family": family, "__slots__": (), "__doc__": doc})
        for family, doc in {
            "shape": "An object: a shape with its material and place.",
            "integrator": "How light is computed.",
            "material": "How a surface scatters light.",
            "texture": "A colour that varies over a surface.",
            "medium": "A participating medium, such as fog.",
            "light": "A light source.",
        }.items()
    }
    bases["camera"] = Camera
    bases[""] = Description
    out = {base.__name__: base for base in bases.values()}
    common = {key["name"]: _key(key) for key in schema["object_keys"] if key["name"] not in ("type", "group")}
    _with(common, [("medium", "medium", "Instead of `material`: the medium inside a surface that is not seen.")])
    for entry in schema["entries"]:
        family, kind = entry["family"], entry["type"]
        keys = {key["name"]: _key(key) for key in entry["keys"]}
        if family == "shape" or kind == "model":
            keys.update({name: key for name, key in common.items() if name not in keys})
        elif family == "light":
            _with(keys, LIGHT_KEYS)
        elif family == "camera":
            _with(keys, CAMERA_KEYS)
        elif kind == "animation":
            _with(keys, [("name", '"text"', "A name.")])
        _add(out, camel(kind) + ENDINGS[family], bases[family], entry, keys, kind if family or kind == "model" else None)
    group = {"name": "group", "kind": '"text"', "doc": "The name of the group.", "shown": None, "value": None}
    doc = {"doc": "An instance of a group of objects.", "type": "instance"}
    _add(out, "Instance", bases["shape"], doc, {"group": group, **common}, "instance")
    return out


def _key(key):
    return {**key, "shown": key["default"], "value": _value(key["default"])}


def _add(out, name, base, entry, keys, kind):
    body = {
        "_type": kind,
        "_keys": keys,
        "_aliases": {**{argument(key): key for key in keys if keyword.iskeyword(key)}, **ALIASES.get(entry["type"], {})},
        "__slots__": (),
        "__doc__": _doc(entry, keys),
        "__module__": "turner",
    }
    out[name] = type(base)(name, (base,), body)


def of_table(family, table):
    """The object of a table of the scene format."""
    kind = table.get("type")
    for cls in classes().values():
        if cls._family == family and cls._type == kind and kind is not None:
            return cls(**{key: value for key, value in table.items() if key != "type"})
    return table
