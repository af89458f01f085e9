"""Scenes: what they contain, by name or by number, to read and to change."""

from __future__ import annotations

import os

from . import _turner
from ._cameras import edits_of
from ._classes import Description, classes, near, of_table

#: The lists of a scene, by their names in Python: the name in a scene file and the family of their items.
LISTS = {
    "objects": ("object", "shape"),
    "lights": ("light", "light"),
    "views": ("view", "camera"),
    "animations": ("animation", ""),
}
TABLES = {
    "materials": ("material", "material"),
    "textures": ("texture", "texture"),
    "media": ("medium", "medium"),
    "groups": ("group", ""),
}
SECTIONS = ("film", "integrator", "background", "studio", "camera")


def quoted(name):
    """A name as a part of a key path."""
    if name and not any(c in name for c in '."\\'):
        return name
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'


class Part:
    """A part of a scene: its keys are attributes, and setting one changes the scene."""

    __slots__ = ("_scene", "_path", "_family")

    def __init__(self, scene, path, family):
        object.__setattr__(self, "_scene", scene)
        object.__setattr__(self, "_path", path)
        object.__setattr__(self, "_family", family)

    def _class(self):
        table = self._scene.get(self._path)
        kind = table.get("type") if isinstance(table, dict) else None
        section = self._path.split(".")[0]
        for cls in classes().values():
            if self._family and cls._family == self._family and cls._type == kind and kind is not None:
                return cls
        return classes().get(
            {"film": "Film", "background": "Background", "studio": "Studio", "animation": "Animation"}.get(section, "")
        )

    def __getattr__(self, key):
        if key.startswith("_"):
            raise AttributeError(key)
        cls = self._class()
        if cls is not None:
            key = cls._aliases.get(key, key)
        value = self._scene.get(f"{self._path}.{key}")
        if value is not None:
            return value
        if key == "type":
            return None if cls is None else cls._type
        if self._path == "film" and key in (depends := self._scene._inner.film_defaults()):
            return depends[key]
        if cls is not None and key not in cls._keys:
            raise AttributeError(f"{self._path} has no key {key!r}{near(key, cls._keys)}")
        return None if cls is None else cls._keys[key].get("value")

    def __setattr__(self, key, value):
        cls = self._class()
        if cls is not None:
            key = cls._key(key)
        if value is not None:
            self._scene.edit({f"{self._path}.{key}": value})
            return
        table = self._scene.get(self._path) or {}
        if key in table:
            self._scene.edit({self._path: {k: v for k, v in table.items() if k != key}})

    def __delattr__(self, key):
        setattr(self, key, None)

    def value(self):
        """The part as one of turner's classes, or a dict."""
        table = self._scene.get(self._path)
        return of_table(self._family, table) if isinstance(table, dict) else table

    def mesh(self):
        """The arrays of a mesh, read-only and without a copy: `positions` (n, 3) float32, `triangles` (m, 3) uint32, and
        `normals`, `uvs`, `tangents`, `colors`, `face_materials` where it has them."""
        section, number = self._path.split(".")[:2]
        if section != "object":
            raise TypeError(f"{self._path} is no object")
        return self._scene._inner.mesh(int(number))

    @property
    def path(self):
        """Its key path, such as "object.3"."""
        return self._path

    def __dir__(self):
        cls = self._class()
        return [*object.__dir__(self), *(cls._keys if cls else ())]

    def __repr__(self):
        return f"<{self._path}: {self.value()!r}>"


class PartList:
    """Objects, lights, views or animations of a scene, by number or by name."""

    def __init__(self, scene, section, family):
        self._scene, self._section, self._family = scene, section, family

    def names(self):
        """The names; None for parts without one."""
        return self._scene._inner.names(self._section)

    def __len__(self):
        return len(self.names())

    def _number(self, key):
        names = self.names()
        if isinstance(key, str):
            if key in names:
                return names.index(key)
            known = [name for name in names if name]
            raise KeyError(f"there is no {self._section} {key!r}{near(key, known)}")
        number = key.__index__()
        if not -len(names) <= number < len(names):
            raise IndexError(f"the scene has {len(names)} {self._section}s; there is no {number}")
        return number % len(names)

    def __getitem__(self, key):
        if isinstance(key, slice):
            return [self[i] for i in range(*key.indices(len(self)))]
        return Part(self._scene, f"{self._section}.{self._number(key)}", self._family)

    def __setitem__(self, key, value):
        self._scene.edit({f"{self._section}.{self._number(key)}": value})

    def __delitem__(self, key):
        numbers = range(*key.indices(len(self))) if isinstance(key, slice) else [self._number(key)]
        self._scene._inner.remove([f"{self._section}.{number}" for number in numbers])

    def __iter__(self):
        return (self[i] for i in range(len(self)))

    def __contains__(self, name):
        return name in self.names()

    def append(self, value):
        """Adds a part and returns it."""
        return self.extend([value])[0]

    def extend(self, values):
        """Adds parts and returns them."""
        paths = self._scene._inner.add(self._section, list(values))
        return [Part(self._scene, path, self._family) for path in paths]

    def __repr__(self):
        return f"<{len(self)} {self._section}s: {', '.join(str(name) for name in self.names()[:8])}>"


class PartTable:
    """Materials, textures, media or groups of a scene, by name."""

    def __init__(self, scene, section, family):
        self._scene, self._section, self._family = scene, section, family

    def names(self):
        """The names."""
        return self._scene._inner.names(self._section)

    keys = names

    def __len__(self):
        return len(self.names())

    def __iter__(self):
        return iter(self.names())

    def __contains__(self, name):
        return name in self.names()

    def __getitem__(self, name):
        names = self.names()
        if name not in names:
            raise KeyError(f"there is no {self._section} {name!r}{near(str(name), names)}")
        return Part(self._scene, f"{self._section}.{quoted(name)}", self._family)

    def __setitem__(self, name, value):
        if self._section == "group" and isinstance(value, (list, tuple)):
            value = {"object": list(value)}
        self._scene.edit({f"{self._section}.{quoted(name)}": value})

    def __delitem__(self, name):
        self._scene._inner.remove([self[name]._path])

    def items(self):
        """Pairs of name and part."""
        return [(name, self[name]) for name in self.names()]

    def __repr__(self):
        return f"<{self._section}s: {', '.join(self.names()[:12])}>"


class Scene:
    """A scene: camera, objects, lights, materials, and how its picture is made.

    `Scene(objects=[Sphere()], lights=[PointLight()], …)` makes one; `turner.load` reads one. Parts are read and changed
    by attributes (`scene.film.samples = 64`, `scene.materials["gold"].specular_roughness`) or by the key paths of scene
    files (`scene.edit({"object.0.radius": 2})`). Between renders only what changed is prepared again.

    Keyword arguments: `camera`, `film`, `integrator` (a name or a class), `background`, `studio`; lists `objects`,
    `lights`, `views`, `animations`; dicts `materials`, `textures`, `media`, `groups` (lists of objects); `folder`, where
    relative paths start. A value is one of turner's classes or a dict with the keys of a scene file.
    """

    def __init__(self, *, folder=".", **parts):
        root = {}
        for name, value in parts.items():
            if value is None:
                continue
            if name in LISTS:
                root[LISTS[name][0]] = list(value)
            elif name == "groups":
                root["group"] = {key: {"object": list(items)} for key, items in value.items()}
            elif name in TABLES:
                root[TABLES[name][0]] = dict(value)
            elif name == "integrator" and isinstance(value, str):
                root["integrator"] = {"type": value}
            elif name == "camera":
                _merge(root, edits_of(value))
            elif name in SECTIONS:
                _merge(root, {name: value})
            else:
                valid = [*SECTIONS, *LISTS, *TABLES]
                raise TypeError(f"Scene has no part {name!r}{near(name, valid)} valid: {', '.join(valid)}")
        self._inner = _turner.Scene.build(root, folder)

    @classmethod
    def _of(cls, inner):
        scene = cls.__new__(cls)
        scene._inner = inner
        return scene

    @classmethod
    def from_toml(cls, text, folder="."):
        """A scene of the text of a scene file. Files that it names are read from `folder`, and may not lie outside it."""
        return cls._of(_turner.Scene.parse(text, folder))

    def get(self, path):
        """The value at a key path; None if it is at its default or the scene does not have it."""
        return self._inner.get(path)

    def edit(self, values):
        """Sets values by key paths, all or none: `{"film.width": 640, "object.0.radius": 2}`."""
        self._inner.edit(dict(values))

    def __getitem__(self, path):
        return self.get(path)

    def __setitem__(self, path, value):
        self.edit({path: value})

    def rename(self, path, name):
        """Renames the part at a key path; references follow. Returns its new key path."""
        return self._inner.rename(path, name)

    def remove(self, *paths):
        """Removes parts by their key paths, with what nothing else uses."""
        self._inner.remove([getattr(path, "path", path) for path in paths])

    def copy(self):
        """A copy whose edits do not change this scene. Meshes and images are shared."""
        return Scene._of(self._inner.copy())

    def info(self):
        """Sizes, bounds, memory, and the camera as numbers, as a dict."""
        return self._inner.info({})

    @property
    def bounds(self):
        """The corners of the box around the objects, (min, max) in scene units; None without bounded objects."""
        return self.info()["bounds"]

    def meshes(self):
        """The arrays of all meshes, as of `scene.objects[0].mesh()`."""
        return self._inner.meshes()

    def save(self, path, overwrite=False):
        """Writes the scene as .toml with its meshes and images in folders beside it, or as .glb. Returns the files."""
        return self._inner.write(os.fspath(path), overwrite)

    def render(self, samples=None, aovs=(), **settings):
        """`turner.render` of this scene."""
        from ._render import render

        return render(self, samples, aovs, **settings)

    def explain(self, x, y, **settings):
        """`turner.explain` of this scene."""
        from ._tools import explain

        return explain(self, x, y, **settings)

    def __getattr__(self, name):
        if name in LISTS:
            return PartList(self, *LISTS[name])
        if name in TABLES:
            return PartTable(self, *TABLES[name])
        if name in SECTIONS:
            return Part(self, name, name if name in ("camera", "integrator") else "")
        raise AttributeError(f"Scene has no attribute {name!r}{near(name, [*SECTIONS, *LISTS, *TABLES])}")

    def __setattr__(self, name, value):
        if name == "_inner":
            object.__setattr__(self, name, value)
        elif name == "camera":
            self._set_camera(value)
        elif name == "integrator":
            self.edit(integrator_edits(self, value))
        elif name in SECTIONS:
            self.edit({name: value})
        elif name in TABLES:
            for key, part in dict(value).items():
                PartTable(self, *TABLES[name])[key] = part
        elif name in LISTS:
            raise AttributeError(f"change `scene.{name}` item by item: append, extend, del")
        else:
            raise AttributeError(f"Scene has no attribute {name!r}{near(name, [*SECTIONS, *LISTS, *TABLES])}")

    def _set_camera(self, camera):
        self.edit(camera_edits(self, camera))

    def __dir__(self):
        return [*object.__dir__(self), *LISTS, *TABLES, *SECTIONS]

    def __copy__(self):
        return self.copy()

    def __repr__(self):
        counts = ", ".join(f"{len(getattr(self, name))} {name}" for name in ("objects", "lights", "materials"))
        return f"<turner.Scene: {counts}>"


def _merge(root, edits):
    for path, value in edits.items():
        section, _, key = path.partition(".")
        plain = value._plain_() if isinstance(value, Description) else value
        table = root.setdefault(section, {})
        if key:
            table[key] = plain
        elif isinstance(plain, dict):
            table.update(plain)
        else:
            root[section] = plain


def camera_edits(scene, camera):
    """What makes a camera that of the scene. The studio's own choice of a camera ends with one that is given."""
    edits = edits_of(camera)
    studio = scene.get("studio")
    if "camera" in edits and isinstance(studio, dict) and "camera" in studio:
        lens = ("camera", "look_at", "fov", "zoom", "f_stop", "focus")
        edits = {"studio": {key: value for key, value in studio.items() if key not in lens}, **edits}
    return edits


def integrator_edits(scene, integrator):
    """What sets an integrator, with the film's defaults for it."""
    table = {"type": integrator} if isinstance(integrator, str) else integrator
    kind = table.get("type") if isinstance(table, dict) else table._type
    if scene.get("integrator.type") == kind:
        if isinstance(integrator, str):
            return {}
        return {"integrator": table}
    return {"integrator": table, "film": scene.get("film") or {}}
