"""Scenes: classes, parts, edits, arrays, errors."""

import copy
import pickle
import sys

import numpy as np
import pytest
import turner as tr
from turner._classes import classes


def test_every_class_shows_its_schema():
    made = classes()
    assert len(made) > 80
    for name, cls in made.items():
        value = cls()
        assert cls.__doc__ and repr(value) == f"{name}()"
        assert dir(value)
        if not isinstance(value, tuple):
            assert pickle.loads(pickle.dumps(value)) == value
    assert "radius" in tr.Sphere.__doc__
    import inspect

    assert "radius" in inspect.signature(tr.Sphere).parameters


def test_examples_of_the_schema_load():
    from turner import _turner

    for entry in _turner.schema()["entries"]:
        names_a_file = any(word in entry["example"] for word in ["file = ", "font = ", "include"])
        if not names_a_file:
            tr.Scene.from_toml(entry["example"])


def test_defaults_of_classes_are_those_of_scenes():
    assert tr.Sphere().radius == 1.0
    assert tr.Film().width == 640
    assert tr.PinholeCamera().look_at == [0, 0, 0]
    assert tr.PathIntegrator().max_depth == tr.Scene(integrator="path").integrator.max_depth


def test_misspelled_names_have_suggestions():
    with pytest.raises(TypeError, match='did you mean "radius"'):
        tr.Sphere(radus=1)
    with pytest.raises(AttributeError, match='did you mean "Sphere"'):
        tr.Spere
    with pytest.raises(TypeError, match='did you mean "objects"'):
        tr.Scene(object=[])


def test_errors_name_the_place():
    with pytest.raises(tr.SceneError) as caught:
        tr.Scene(objects=[{"type": "sphere"}, {"type": "sphere", "radus": 1}], lights=[{"type": "pont"}])
    error = caught.value
    assert error.code == "E0102" and error.path == "objects[1].radus" and "`radius`" in error.help
    assert [other.path for other in error.others] == ["lights[0].type"]
    assert error.line is None
    with pytest.raises(tr.SceneError) as caught:
        tr.Scene.from_toml("[film]\nwidth = -1\n")
    assert (caught.value.line, caught.value.column) == (2, 9)
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.code, again.line, str(again)) == (caught.value.code, 2, str(caught.value))


def test_wrong_values_change_nothing(scene):
    before = scene.film.value()
    with pytest.raises(tr.SceneError):
        scene.edit({"film.width": 100, "film.height": "tall"})
    assert scene.film.value() == before
    with pytest.raises(TypeError, match="no value of a scene"):
        scene.edit({"film.width": object()})
    deep = []
    for _ in range(200):
        deep = [deep]
    with pytest.raises(ValueError, match="nest deeper"):
        scene.edit({"film.crop": deep})
    looped = []
    looped.append(looped)
    with pytest.raises(ValueError, match="nest deeper"):
        scene.edit({"film.crop": looped})


def test_parts_are_read_and_changed(scene):
    ball = scene.objects["ball"]
    ball.radius = 0.5
    assert ball.radius == 0.5 and ball.type == "sphere" and ball.center == [0, 1, 0]
    ball.radius = None
    assert ball.radius == 1.0 and "radius" not in scene.get("object.0")
    with pytest.raises(TypeError, match='did you mean "radius"'):
        ball.radus = 1
    with pytest.raises(AttributeError):
        ball.radus
    scene.materials["gold"] = tr.PrincipledMaterial(base_metalness=1, base_color=(1, 0.8, 0.3))
    ball.material = "gold"
    scene.materials["gold"].specular_roughness = 0.2
    assert scene.get("material.gold.specular_roughness") == 0.2
    assert "gold" in scene.materials and len(scene.materials) >= 1
    scene.rename("material.gold", "brass")
    assert ball.material == "brass"
    added = scene.objects.extend([tr.Box(name="a"), tr.Box(name="b", material="brass")])
    assert [part.name for part in added] == ["a", "b"] and len(scene.objects) == 4
    del scene.objects["a"]
    assert scene.objects.names() == ["ball", "floor", "b"]
    scene.lights.append(tr.SpotLight(name="spot", position=(0, 5, 0), look_at=(0, 0, 0)))
    assert scene.lights["spot"].type == "spot"
    scene.groups["pair"] = [tr.Sphere(), tr.Box()]
    scene.objects.append(tr.Instance(group="pair", transform={"translate": [3, 0, 0]}))
    assert tr.render(scene, 1, aovs=["instance_id"]).complete
    with pytest.raises(KeyError, match="did you mean"):
        scene.objects["bal"]
    with pytest.raises(IndexError):
        scene.objects[99]


def test_a_copy_is_independent(scene):
    other = copy.copy(scene)
    other.objects["ball"].radius = 3
    assert scene.objects["ball"].radius == 1


def test_meshes_go_in_and_come_out(bumpy):
    points, faces, normals, uv = bumpy
    scene = tr.Scene(objects=[tr.Mesh(vertices=points, faces=faces, normals=normals, uv=uv, name="m")])
    mesh = scene.objects["m"].mesh()
    assert np.allclose(mesh["positions"], points, atol=1e-6) and np.array_equal(mesh["triangles"], faces)
    assert np.allclose(mesh["uvs"], uv, atol=1e-6)
    with pytest.raises(ValueError):
        mesh["positions"][0, 0] = 7
    # Views of the renderer's memory: two of them share it, and they outlive the scene.
    again = scene.objects["m"].mesh()["positions"]
    assert np.shares_memory(again, mesh["positions"])
    del scene
    assert np.isfinite(again).all()


@pytest.mark.parametrize("kind", ["float64", "float32", "float16", "strided", "fortran", "readonly", "list", "big"])
def test_layouts_of_arrays(bumpy, kind):
    points, faces, _, _ = bumpy
    given = {
        "float64": lambda: points.astype(np.float64),
        "float32": lambda: points.astype(np.float32),
        "float16": lambda: points.astype(np.float16),
        "strided": lambda: np.repeat(points, 2, 0)[::2],
        "fortran": lambda: np.asfortranarray(points),
        "readonly": lambda: points.copy(),
        "list": lambda: points.tolist(),
        "big": lambda: points.astype(">f8"),
    }[kind]()
    if kind == "readonly":
        given.flags.writeable = False
    kinds = {"float16": np.uint16, "float32": np.int32, "big": ">i8", "list": int}
    scene = tr.Scene(objects=[tr.Mesh(vertices=given, faces=faces.astype(kinds.get(kind, np.int64)), name="m")])
    tolerance = 1e-3 if kind == "float16" else 1e-6
    assert np.allclose(scene.objects["m"].mesh()["positions"], points, atol=tolerance)


def test_bad_arrays_are_refused(bumpy):
    points, faces, _, _ = bumpy
    bad = [
        (dict(vertices=points[:, :2], faces=faces), "positions.*expected .n, 3."),
        (dict(vertices=points, faces=faces.astype(float)), "whole numbers"),
        (dict(vertices=points, faces=faces - 5), "no index"),
        (dict(vertices=points, faces=faces + 10_000), "names vertex"),
        (dict(vertices=points, faces=faces[:, :2]), "three indices"),
        (dict(faces=faces), "needs `positions`"),
        (dict(vertices=points, faces=faces, normals=points[:3]), "normals"),
    ]
    for keys, message in bad:
        with pytest.raises((ValueError, TypeError), match=message):
            tr.Scene(objects=[tr.Mesh(**keys)])


def test_polygons_and_colors_of_arrays():
    corners = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], float)
    mesh = tr.Mesh(positions=corners, polygons=np.array([[3, 2, 1, 0]]), colors=np.eye(4)[:, :3], name="m")
    scene = tr.Scene(objects=[mesh])
    assert len(scene.objects["m"].mesh()["triangles"]) == 2
    bytes_ = tr.Mesh(positions=corners, triangles=np.array([[0, 2, 1]]), colors=np.full((4, 4), 188, np.uint8), name="m")
    colors = tr.Scene(objects=[bytes_]).objects["m"].mesh()["colors"]
    # Byte colours are encoded by the sRGB curve, as in PLY files; alpha is not.
    assert np.allclose(colors[0], [0.5029, 0.5029, 0.5029, 188 / 255], atol=1e-3)


def test_textures_environments_and_grids_from_arrays():
    checks = np.indices((8, 8)).sum(0) % 2
    sky = np.full((16, 32, 3), 0.5, np.float32)
    scene = tr.Scene(
        objects=[
            tr.Rectangle(
                material={"type": "principled", "base_color": {"type": "image", "file": (checks * 255).astype(np.uint8)}}
            )
        ],
        lights=[tr.EnvironmentLight(file=sky)],
        film={"width": 8, "height": 8},
        integrator="path",
    )
    assert tr.render(scene, 1).complete
    away = tr.Camera.look_at((0, 0, 0), (0, 0, -1))
    white = tr.Scene(
        objects=[tr.Sphere(center=(9, 9, 9))],
        lights=[tr.EnvironmentLight(file=sky)],
        integrator="path",
        camera=away,
        film={"width": 8, "height": 8},
    )
    assert np.allclose(tr.render(white, 4).image[..., :3], 0.5, atol=1e-6)
    smoke = np.ones((4, 4, 4))
    fog = tr.Scene(
        objects=[tr.Box(min=(-1, -1, -1), max=(1, 1, 1), medium={"type": "grid", "file": smoke, "scattering": 1.0})],
        lights=[tr.EnvironmentLight(file=sky)],
        integrator="path",
        film={"width": 8, "height": 8},
    )
    assert tr.render(fog, 4).non_finite == 0
    with pytest.raises(ValueError, match="expected .height, width"):
        tr.Scene(lights=[tr.EnvironmentLight(file=np.zeros((4, 4, 7)))])
    with pytest.raises(TypeError, match="int64"):
        tr.Scene(lights=[tr.EnvironmentLight(file=np.zeros((4, 4, 3), int))])


def test_scenes_are_saved_and_read_again(scene, bumpy, tmp_path):
    points, faces, _, _ = bumpy
    scene.objects.append(tr.Mesh(vertices=points, faces=faces, name="m", transform=np.diag([1, 2, 1, 1.0])))
    files = scene.save(tmp_path / "scene.toml")
    assert any(str(file).endswith(".ply") for file in files)
    again = tr.load(tmp_path / "scene.toml")
    assert np.array_equal(tr.render(again, 2).image, tr.render(scene, 2).image)
    with pytest.raises(tr.SceneError, match="exists"):
        scene.save(tmp_path / "scene.toml")
    scene.save(tmp_path / "scene.toml", overwrite=True)
    scene.save(tmp_path / "scene.glb")
    model = tr.load(tmp_path / "scene.glb", warn=False)
    assert "m" in " ".join(tr.render(model, 1, aovs=["object_id"]).names.values())
    assert tr.convert(tmp_path / "scene.glb", tmp_path / "model.toml")


def test_files_stay_in_their_folder(tmp_path):
    (tmp_path / "inner").mkdir()
    (tmp_path / "secret.png").write_bytes(b"")
    text = '[texture.a]\ntype = "image"\nfile = "../secret.png"\n'
    (tmp_path / "inner" / "a.toml").write_text(text)
    with pytest.raises(tr.SceneError, match="secret"):
        tr.load(tmp_path / "inner" / "a.toml")
    with pytest.raises(tr.SceneError):
        tr.load(tmp_path / "missing.toml")


def test_warnings_are_python_s():
    scene = tr.Scene(objects=[tr.Sphere()], film={"filter": "gaussian", "width": 8, "height": 8})
    with pytest.warns(tr.SceneWarning, match="filter"):
        tr.render(scene)


def test_tools(scene):
    explanation = scene.explain(32, 24)
    assert explanation["pixel"] == [32, 24] and explanation["exact"]
    assert "ball" in explanation.text() and "<html" in explanation.html() and "<svg" in explanation.svg()
    assert "iframe" in explanation._repr_html_()
    with pytest.raises(tr.SceneError):
        scene.explain(9999, 0)
    findings = tr.doctor(scene, seconds=5)
    assert "findings" in findings and findings["summary"]["samples"] > 0
    a, b = np.zeros((8, 8, 3)), np.full((8, 8, 3), 0.5)
    assert tr.compare(a, b)["max"] == pytest.approx(0.5)
    assert tr.compare(a, a)["flip"] == 0
    with pytest.raises(ValueError):
        tr.compare(a, np.zeros((4, 4, 3)))


def test_import_is_light():
    import subprocess

    code = "import sys, turner; assert 'numpy' not in sys.modules and 'asyncio' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_command_line_is_in_the_module():
    import subprocess

    out = subprocess.run([sys.executable, "-m", "turner", "--version"], capture_output=True, text=True, check=True)
    assert tr.__version__ in out.stdout
    bad = subprocess.run([sys.executable, "-m", "turner", "render", "no.toml"], capture_output=True, text=True)
    assert bad.returncode == 1 and "no.toml" in bad.stderr


def test_subinterpreters_are_refused_with_a_word():
    import subprocess

    code = """
import turner
try:
    import _interpreters as interpreters
except ImportError:
    import _xxsubinterpreters as interpreters
i = interpreters.create()
text = "try:\\n    import turner\\nexcept ImportError as e:\\n    print('refused:', e)\\nelse:\\n    print('imported')"
print(interpreters.run_string(i, text) or "", flush=True)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    if "No module named" in done.stderr:
        pytest.skip("this Python has no subinterpreters to try")
    assert "refused:" in done.stdout and "subinterpreter" in done.stdout, done.stdout + done.stderr
