//! The tables of [`super::foreign`]. The first matching entry wins, so narrow contexts come first.

use super::foreign::Foreign;

const OBJECT: &[&str] = &["shape", "object", "instance", "a model"];
const CLASSIC: &[&str] = &["material \"classic\""];
const PRINCIPLED: &[&str] = &["material \"principled\""];
const MATERIAL: &[&str] = &["material"];
const CAMERA: &[&str] = &["camera", "a view"];
const LIGHT: &[&str] = &["light"];
const FILM: &[&str] = &["[film]"];
const INTEGRATOR: &[&str] = &["integrator"];
const TEXTURE: &[&str] = &["texture"];
const BACKGROUND: &[&str] = &["[background]"];
const SCENE: &[&str] = &["the scene"];
const SHAPE: &[&str] = &["shape"];
const MEDIUM: &[&str] = &["medium"];
const AOV: &[&str] = &["aov"];

macro_rules! words {
    ($($within:expr, $($word:literal)|+ => $remedy:literal;)*) => {
        &[$(Foreign { within: $within, words: &[$($word),+], remedy: $remedy },)*]
    };
}

/// Keys.
pub const KEYS: &[Foreign] = words! {
    // Objects.
    OBJECT, "color" | "colour" | "pigment" | "diffuse" | "albedo" | "basecolor" | "rgb" =>
        "a colour belongs in the material: `material = { color = \"red\" }`";
    OBJECT, "texture" | "map" =>
        "a texture is the colour of a material: `material = { color = \"NAME\" }` with a section `[texture.NAME]`";
    OBJECT, "reflection" | "reflectivity" | "mirror" =>
        "reflection belongs in the material: `material = { k_reflect = 0.5 }`";
    OBJECT, "specular" | "phong" | "shininess" | "finish" =>
        "highlights belong in the material: `material = { ks = 0.5, shininess = 50 }`";
    OBJECT, "roughness" | "metallic" | "metalness" =>
        "this belongs in the material: `material = { type = \"metal\", roughness = 0.2 }`, or `type = \"principled\"` with `base_metalness` and `specular_roughness`";
    OBJECT, "ior" | "transparency" | "transmission" | "refraction" | "glass" =>
        "this belongs in the material: `material = { type = \"dielectric\", ior = 1.5 }`";
    OBJECT, "opacity" | "alpha" => "opacity belongs in the material: `material = { opacity = 0.5 }`";
    OBJECT, "visible" | "hide" | "hiderender" | "invisible" | "disabled" | "enabled" =>
        "write `hidden = true` to leave an object out";
    OBJECT, "visiblecamera" | "cameravisible" | "primaryvisibility" | "visibletocamera" =>
        "write `hidden_from_camera = true` to hide an object from the camera alone";
    OBJECT, "isshadowcatcher" | "shadowmatte" | "matteshadow" => "write `shadow_catcher = true`";
    OBJECT, "emission" | "emissive" | "emit" | "glow" | "light" =>
        "an object emits light by its material: `material = { type = \"emissive\", strength = 5 }`";
    OBJECT, "bsdf" | "shader" | "surface" => "write the material in place: `material = { type = \"matte\" }`, or name it: `material = \"NAME\"`";
    OBJECT, "position" | "location" | "pos" | "origin" =>
        "write `center = [x, y, z]` where the shape has that key, otherwise `transform = { translate = [x, y, z] }`";
    OBJECT, "translate" | "translation" => "write `transform = { translate = [x, y, z] }`";
    OBJECT, "rotate" | "rotation" => "write `transform = { rotate = [x, y, z] }`, angles in degrees";
    OBJECT, "scale" => "write `transform = { scale = 2 }`, or `scale = [x, y, z]` in it";
    OBJECT, "toworld" | "matrix" => "write `transform = { matrix = [12 or 16 numbers, row by row] }`";
    &["shape \"sphere\""], "size" | "diameter" => "write `radius`: half the diameter";
    OBJECT, "diameter" => "write `radius`: half the diameter";
    OBJECT, "size" | "width" | "height" | "depth" | "length" =>
        "a box has `size = [x, y, z]`, round shapes have `radius`; any object can be scaled: `transform = { scale = [x, y, z] }`";
    OBJECT, "vertices" | "points" | "p" => "write `positions = [[x, y, z], …]`";
    OBJECT, "faces" | "indices" | "triangle" | "index" => "write `triangles = [[0, 1, 2], …]`: the indices of three vertices each";
    OBJECT, "filename" | "src" | "path" | "url" | "uri" => "write `file = \"FILE\"`";
    // Materials.
    CLASSIC, "reflection" | "reflectivity" | "mirror" => "write `k_reflect`: the weight of the reflected ray, 0 to 1";
    CLASSIC, "specular" | "phong" => "write `ks` for the strength and `shininess` for the exponent of the highlight";
    CLASSIC, "phongsize" | "exponent" | "specularexponent" | "n" => "write `shininess`: the exponent of the highlight";
    CLASSIC, "diffuse" => "write `kd` for the weight of diffuse reflection; the colour is `color`";
    CLASSIC, "ambient" => "write `ka` for the weight of ambient light";
    CLASSIC, "roughness" | "glossiness" =>
        "the material \"classic\" has `gloss` or `shininess`; for a roughness write `type = \"principled\"` and `specular_roughness`";
    CLASSIC, "metallic" | "metalness" | "metal" =>
        "write `type = \"metal\"`, or `type = \"principled\"` and `base_metalness = 1`";
    CLASSIC, "transparency" | "transmission" | "refraction" | "filter" | "transmit" =>
        "write `k_refract` for the weight of the refracted ray and `ior` for the index of refraction";
    PRINCIPLED, "metallic" | "metalness" | "metal" => "write `base_metalness`";
    PRINCIPLED, "roughness" => "write `specular_roughness`; the roughness of the diffuse base is `base_diffuse_roughness`";
    PRINCIPLED, "basecolor" | "color" | "colour" | "diffuse" | "albedo" | "diffusecolor" | "reflectance" | "pigment" => "write `base_color`";
    PRINCIPLED, "specular" | "specularlevel" => "write `specular_weight`; the colour is `specular_color`";
    PRINCIPLED, "transmission" | "transparency" | "spectrans" => "write `transmission_weight`";
    PRINCIPLED, "subsurface" | "sss" => "write `subsurface_weight`, with `subsurface_color` and `subsurface_radius`";
    PRINCIPLED, "clearcoat" | "coat" => "write `coat_weight`";
    PRINCIPLED, "clearcoatroughness" => "write `coat_roughness`";
    PRINCIPLED, "sheen" | "fuzz" | "velvet" => "write `fuzz_weight`";
    PRINCIPLED, "sheentint" | "sheencolor" => "write `fuzz_color`";
    PRINCIPLED, "sheenroughness" => "write `fuzz_roughness`";
    PRINCIPLED, "emission" | "emissive" | "emissionstrength" | "emissiveintensity" =>
        "write `emission_luminance` for the strength and `emission_color` for the colour";
    PRINCIPLED, "anisotropic" | "anisotropy" => "write `specular_roughness_anisotropy`";
    PRINCIPLED, "iridescence" | "thinfilm" => "write `thin_film_weight` and `thin_film_thickness`";
    PRINCIPLED, "ior" | "eta" | "intior" => "write `specular_ior`";
    MATERIAL, "subsurface" | "sss" => "write `type = \"principled\"` with `subsurface_weight` and `subsurface_radius`";
    MATERIAL, "clearcoat" | "coat" => "write `type = \"principled\"` with `coat_weight`, or `type = \"plastic\"`";
    MATERIAL, "sheen" => "write `type = \"principled\"` with `fuzz_weight`";
    MATERIAL, "emission" | "emissive" | "emit" | "le" | "glow" =>
        "write `type = \"emissive\"` with `color` and `strength`, or `type = \"principled\"` with `emission_luminance`";
    MATERIAL, "metallic" | "metalness" => "write `type = \"principled\"` with `base_metalness`";
    MATERIAL, "basecolor" | "diffuse" | "diffusecolor" | "reflectance" | "albedo" | "pigment" | "kd" | "rgb" | "specularreflectance" =>
        "write `color`";
    MATERIAL, "texture" | "map" | "image" | "basecolortexture" =>
        "name the texture as the colour: `color = \"NAME\"` with a section `[texture.NAME]`";
    MATERIAL, "intior" | "eta" | "indexofrefraction" | "refractiveindex" => "write `ior`";
    MATERIAL, "alpha" | "transparency" => "write `opacity`, 1 for an opaque surface";
    MATERIAL, "finish" | "bsdf" => "write the keys directly in the material, e.g. `ks = 0.5`, `k_reflect = 0.2`; `turner help material` lists its kinds";
    MATERIAL, "alphatest" | "alphathreshold" => "write `alpha_cutoff`";
    MATERIAL, "wireframe" => "a wireframe is an integrator: `[integrator]` with `type = \"wireframe\"`";
    // Cameras.
    CAMERA, "eye" | "location" | "origin" | "from" | "pos" | "lookfrom" => "write `position = [x, y, z]`";
    CAMERA, "lookat" | "target" | "to" | "at" | "center" | "interest" => "write `look_at = [x, y, z]`, the point that the camera is aimed at";
    CAMERA, "direction" | "forward" | "dir" => "write `look_at = [x, y, z]`, a point: the position plus the direction";
    CAMERA, "rotation" | "rotate" | "toworld" | "transform" => "write `position`, `look_at` and `up`";
    CAMERA, "fovy" | "fieldofview" | "viewangle" | "zoom" | "focallength" | "angle" | "yfov" => "write `fov`: the vertical field of view in degrees";
    CAMERA, "sky" | "vup" | "upvector" => "write `up = [0, 1, 0]`";
    CAMERA, "aperture" | "fstop" | "lensradius" | "apertureradius" | "dof" | "depthoffield" =>
        "write `type = \"thin-lens\"` with `lens_radius` and `focus_distance`";
    CAMERA, "focus" | "focusdistance" | "focaldistance" | "focalpoint" =>
        "write `type = \"thin-lens\"` with `focus_distance` and `lens_radius`";
    CAMERA, "width" | "height" | "resolution" | "size" | "aspect" | "aspectratio" =>
        "the size of the picture belongs in `[film]`: `width = 640`, `height = 480`";
    CAMERA, "nearclip" | "nearplane" | "clipstart" | "znear" | "hither" => "write `near`, the distance at which the view begins";
    CAMERA, "farclip" | "farplane" | "clipend" | "zfar" | "yon" => "write `far`, the distance at which the view ends";
    CAMERA, "samples" | "spp" => "samples per pixel belong in `[film]`: `samples = 64`";
    CAMERA, "exposure" | "film" => "exposure belongs in `[film]`: `exposure = 1`, in stops";
    CAMERA, "shutter" | "shutteropen" | "shutterclose" => "the shutter belongs in `[film]`: `shutter = [0, 0.5]`";
    // Lights.
    &["light \"spot\""], "direction" | "target" | "to" | "dir" => "write `look_at = [x, y, z]`, the point that the light is aimed at";
    &["light \"spot\""], "coneangle" | "cutoff" | "cutoffangle" | "spotsize" | "radius" | "fov" => "write `angle`: from the axis to the rim of the cone, degrees";
    &["light \"spot\""], "blend" | "falloff" | "beamwidth" | "conedeltaangle" | "tightness" => "write `penumbra`: the width of the soft rim, degrees";
    &["light \"directional\""], "position" | "location" | "pos" => "write `from = [x, y, z]`, the direction that the light comes from";
    &["light \"rectangle\""], "size" | "width" | "height" => "write `edge_u = [x, y, z]` and `edge_v = [x, y, z]`, the two edges";
    &["light \"rectangle\"", "light \"disk\"", "light \"sphere\""], "position" | "location" | "pos" => "write `center = [x, y, z]`";
    &["light \"environment\"", "light \"sky\""], "intensity" | "power" | "energy" | "scale" | "brightness" => "write `strength`";
    &["light \"environment\""], "filename" | "map" | "image" | "texture" | "mapname" => "write `file = \"FILE\"`";
    LIGHT, "energy" | "power" | "strength" | "watts" | "brightness" | "scale" | "lumens" => "write `intensity`";
    LIGHT, "colour" | "l" | "le" | "i" | "emission" | "radiance" | "irradiance" | "rgb" => "write `color` and `intensity`";
    LIGHT, "location" | "pos" | "center" => "write `position = [x, y, z]`";
    LIGHT, "decay" | "falloff" => "write `attenuation`: how the light falls off with distance";
    LIGHT, "radius" | "size" | "softness" => "a light with an area has `type = \"sphere\"` and `radius`, or `type = \"rectangle\"`";
    LIGHT, "castshadow" | "shadow" | "shadows" | "shadowless" => "all lights cast shadows; `[integrator]` has `shadows = false` for `type = \"classic\"`";
    // Film.
    FILM, "firefly" | "fireflyremoval" | "rejectoutliers" | "outlierrejection" | "outliers" | "indirectsampleclamp" | "aasampleclamp" | "varianceclamping" => "write `fireflies = \"remove\"`; `clamp_sample` limits every sample";
    FILM, "aov" | "passes" | "outputs" | "channels" | "renderpasses" | "layers" => "write `aovs = [\"albedo\", \"normal\"]`";
    FILM, "size" | "resolution" | "res" | "xresolution" | "yresolution" | "dimensions" => "write `width = 640` and `height = 480`, in pixels";
    FILM, "spp" | "samplesperpixel" | "pixelsamples" | "samplecount" | "quality" => "write `samples = 64`, the samples per pixel";
    FILM, "gamma" | "colorspace" | "colourspace" => "write `transfer = \"srgb\"`";
    FILM, "aa" | "antialiasing" | "supersampling" => "write `antialias = \"monte-carlo\"`";
    FILM, "background" => "the background is a section: `[background]` with `color = \"white\"`";
    FILM, "filename" | "output" | "file" | "format" => "name the file on the command line: `-o FILE`";
    FILM, "denoiser" | "oidn" | "optix" => "write `denoise = \"on\"`";
    FILM, "rfilter" | "pixelfilter" | "reconstructionfilter" => "write `filter`";
    FILM, "tonemapping" => "write `tonemap`";
    FILM, "integrator" => "the integrator is a section: `[integrator]` with `type = \"path\"`";
    // Integrator.
    INTEGRATOR, "depth" | "maxbounces" | "bounces" | "recursion" | "maxtracelevel" | "recursiondepth" => "write `max_depth`";
    INTEGRATOR, "samples" | "spp" | "samplesperpixel" | "quality" => "samples per pixel belong in `[film]`: `samples = 64`";
    INTEGRATOR, "rrdepth" | "russianroulette" => "write `rr_start` with `type = \"path\"`";
    INTEGRATOR, "clamp" | "firefly" | "radianceclamp" | "clampindirect" => "write `clamp_indirect` with `type = \"path\"`";
    INTEGRATOR, "denoise" | "denoiser" => "write `denoise = \"on\"` in `[film]`";
    INTEGRATOR, "photons" | "photonmap" => "write `caustics = \"full\"` with `type = \"path\"`";
    INTEGRATOR, "seed" => "the seed belongs in `[film]`: `seed = 1`";
    INTEGRATOR, "name" | "method" | "engine" => "write `type = \"path\"`, or another integrator: `turner list integrators`";
    // Background.
    BACKGROUND, "image" | "file" | "texture" | "envmap" | "map" | "hdri" | "hdr" => "an environment map is a light: `[[light]]` with `type = \"environment\"` and `file = \"FILE\"`";
    BACKGROUND, "type" => "a background has no type: write `color`, and `zenith` for a gradient";
    BACKGROUND, "colour" | "horizon" => "write `color`";
    BACKGROUND, "top" | "sky" => "write `zenith`: the colour straight up";
    BACKGROUND, "strength" | "intensity" => "write the colour as numbers, which may exceed 1: `color = [2, 2, 2]`";
    // Textures.
    TEXTURE, "scale" | "frequency" | "repeat" | "tiling" | "size" => "write `density`: how often the pattern repeats, or `transform = { scale = 2 }`";
    TEXTURE, "filename" | "src" | "path" | "url" | "image" => "write `file = \"FILE\"`";
    TEXTURE, "color1" | "colora" | "tex1" | "checkcolor1" => "a checkerboard has `even` and `odd`, other textures of two colours have `a` and `b`";
    TEXTURE, "color2" | "colorb" | "tex2" | "checkcolor2" | "colors" => "a checkerboard has `even` and `odd`, other textures of two colours have `a` and `b`";
    TEXTURE, "colour" => "write `color`";
    // Transforms.
    &["a transform"], "position" | "location" | "translation" | "move" => "write `translate = [x, y, z]`";
    &["a transform"], "rotation" | "euler" | "quaternion" => "write `rotate = [x, y, z]` in degrees, or `rotate = { axis = [x, y, z], angle = 45 }`";
    // Sections.
    SCENE, "width" | "height" | "size" | "resolution" | "image" | "output" =>
        "the size of the picture belongs in `[film]`: `width = 640`, `height = 480`";
    SCENE, "samples" | "spp" | "sampler" => "samples per pixel belong in `[film]`: `samples = 64`";
    SCENE, "render" | "renderer" | "settings" | "globalsettings" | "options" =>
        "settings belong in `[film]` (`width`, `height`, `samples`) and `[integrator]` (`type`, `max_depth`)";
    SCENE, "sphere" | "box" | "plane" | "mesh" | "cube" | "shape" | "shapes" | "geometry" | "objects" | "primitive" | "primitives" =>
        "objects are a list: `[[object]]` with `type = \"sphere\"` or another shape";
    SCENE, "lightsource" | "lights" | "pointlight" | "sun" | "emitter" | "emitters" | "lamp" =>
        "lights are a list: `[[light]]` with `type = \"point\"` or another kind";
    SCENE, "ambient" | "ambientlight" => "ambient light is a light: `[[light]]` with `type = \"ambient\"` and `color = 0.1`";
    SCENE, "materials" | "bsdf" | "bsdfs" | "shader" => "materials have names: `[material.NAME]`";
    SCENE, "textures" | "pigment" => "textures have names: `[texture.NAME]`";
    SCENE, "world" | "environment" | "envmap" | "skybox" | "skysphere" | "hdri" =>
        "an environment map is a light: `[[light]]` with `type = \"environment\"` and `file = \"FILE\"`; a plain colour is `[background]` with `color`";
    SCENE, "sky" => "a sky is a light: `[[light]]` with `type = \"sky\"`, or `[background]` with `color` and `zenith`";
    SCENE, "fog" | "volume" | "media" | "smoke" => "media have names: `[medium.NAME]`; fog fills the scene by `[background]` with `medium = \"NAME\"`";
    SCENE, "cameras" | "perspectivecamera" | "sensor" | "viewpoint" => "write `[camera]`, and `[[view]]` for further cameras";
    SCENE, "fov" | "position" | "lookat" | "eye" => "this belongs in `[camera]`: `position`, `look_at`, `fov`";
    SCENE, "instance" | "groups" => "a group is `[[group.NAME.object]]`; `[[object]]` with `type = \"instance\"` and `group = \"NAME\"` places it";
    SCENE, "maxdepth" | "depth" | "bounces" | "pathtracer" => "this belongs in `[integrator]`: `type = \"path\"`, `max_depth = 8`";
};

/// Values of `type`.
pub const KINDS: &[Foreign] = words! {
    // Shapes.
    SHAPE, "cube" | "cuboid" | "boxgeometry" | "aabb" | "block" => "write `type = \"box\"` with `size = [1, 1, 1]` and `center`";
    SHAPE, "ball" | "spheregeometry" | "uvsphere" | "icosphere" => "write `type = \"sphere\"` with `center` and `radius`";
    SHAPE, "quad" | "square" | "rect" | "planegeometry" => "write `type = \"rectangle\"` with `center`, `edge_u` and `edge_v`; an infinite plane is `type = \"plane\"`";
    SHAPE, "ground" | "floor" | "infiniteplane" => "write `type = \"plane\"` with `point` and `normal`";
    SHAPE, "circle" | "disc" | "circlegeometry" => "write `type = \"disk\"` with `center`, `normal` and `radius`";
    SHAPE, "tube" | "cylindergeometry" => "write `type = \"cylinder\"` with `from`, `to` and `radius`";
    SHAPE, "conegeometry" | "frustum" | "pyramid" => "write `type = \"cone\"` with `from`, `to`, `radius` and `tip_radius`; a pyramid is a `mesh`";
    SHAPE, "donut" | "doughnut" | "torusgeometry" => "write `type = \"torus\"` with `radius` and `tube_radius`";
    SHAPE, "trianglemesh" | "triangle" | "triangles" | "polygon" | "polygons" | "mesh2" | "plymesh" | "ply" | "stl" | "buffergeometry" =>
        "write `type = \"mesh\"` with `file`, or with `positions` and `triangles`";
    SHAPE, "obj" | "gltf" | "glb" | "fbx" | "import" | "asset" => "write `type = \"model\"` with `file = \"FILE\"`";
    SHAPE, "pointcloud" | "particles" | "spheres" => "write `type = \"points\"` with `positions` and `radius`";
    SHAPE, "hair" | "curve" | "strands" | "bsplinecurve" | "linearcurve" | "fur" => "write `type = \"curves\"` with `file` or `points`";
    SHAPE, "group" | "shapegroup" | "object" => "write `type = \"instance\"` with `group = \"NAME\"`, and the objects as `[[group.NAME.object]]`";
    SHAPE, "csg" | "boolean" | "merge" | "subtract" | "subtraction" | "cut" =>
        "write `type = \"union\"`, `\"intersection\"`, `\"difference\"` or `\"clipped\"` with tables `[[object.parts]]`";
    SHAPE, "clippedby" | "clip" => "write `type = \"clipped\"`: the first of its `[[object.parts]]` is clipped by the others";
    SHAPE, "superquadric" | "roundbox" | "roundedbox" => "write `type = \"superellipsoid\"` with `east_west` and `north_south`";
    SHAPE, "sor" | "surfaceofrevolution" | "revolution" | "revolve" | "lathegeometry" => "write `type = \"lathe\"` with `points`";
    SHAPE, "extrude" | "extrusion" | "linearextrude" | "extrudegeometry" => "write `type = \"prism\"` with `points`, `bottom` and `top`";
    SHAPE, "metaball" | "metaballs" | "blobby" => "write `type = \"blob\"` with `spheres`";
    SHAPE, "sdf" | "implicit" | "function" | "distancefield" => "write `type = \"isosurface\"` with `function`, `min` and `max`; a grid of distances is `type = \"distance_grid\"` with `file`";
    SHAPE, "sdfgrid" | "distancegrid" | "levelset" | "voxels" | "vdb" | "volume" => "write `type = \"distance_grid\"` with `file`";
    SHAPE, "parametricgeometry" | "parametricsurface" => "write `type = \"parametric\"` with `x`, `y` and `z` in u and v";
    SHAPE, "textgeometry" | "text3d" | "ttf" | "font" => "write `type = \"text\"` with `text` and `font`";
    SHAPE, "poly" | "quartic" | "cubic" => "write `type = \"polynomial\"` with `terms`";
    SHAPE, "ellipsoid" | "paraboloid" | "hyperboloid" => "write `type = \"quadric\"`; an ellipsoid is a sphere with `transform = { scale = [1, 2, 3] }`";
    SHAPE, "capsule" | "capsulegeometry" | "tubegeometry" | "pipe" => "write `type = \"sphere_sweep\"` with `spheres`";
    SHAPE, "light" | "lightsource" | "pointlight" | "emitter" | "area" => "lights are a list of their own: `[[light]]` with `type = \"point\"`; an object emits light with `material = { type = \"emissive\" }`";
    // Materials.
    MATERIAL, "lambert" | "lambertian" | "diffuse" | "orennayar" => "write `type = \"matte\"` with `color`";
    MATERIAL, "meshlambertmaterial" | "meshphongmaterial" | "phong" | "blinn" | "whitted" | "finish" | "pigment" => "write `type = \"classic\"` with `color`, `kd`, `ks` and `shininess`";
    MATERIAL, "meshbasicmaterial" => "write `type = \"principled\"` with `unlit = true`";
    MATERIAL, "meshstandardmaterial" | "meshphysicalmaterial" | "principledbsdf" | "openpbr" | "pbr" | "standard" | "uber" | "bsdf" | "standardsurface" =>
        "write `type = \"principled\"` with `base_color`, `base_metalness` and `specular_roughness`";
    MATERIAL, "burley" | "principledthin" => "write `type = \"disney\"`";
    MATERIAL, "conductor" | "roughconductor" | "metallic" | "glossy" | "gold" | "copper" => "write `type = \"metal\"` with `roughness`, and `name = \"gold\"` or `color`";
    MATERIAL, "mirror" => "write `type = \"metal\"` with `roughness = 0`, or `type = \"classic\"` with `k_reflect = 1`";
    MATERIAL, "glass" | "refractive" | "transparent" | "roughdielectric" | "water" | "refraction" => "write `type = \"dielectric\"` with `ior = 1.5`";
    MATERIAL, "thindielectric" => "write `type = \"dielectric\"` with `thin = true`";
    MATERIAL, "coateddiffuse" | "roughplastic" | "substrate" | "coated" => "write `type = \"plastic\"` with `color` and `roughness`";
    MATERIAL, "emission" | "emitter" | "light" | "area" | "arealight" | "diffuselight" => "write `type = \"emissive\"` with `color` and `strength`";
    MATERIAL, "blend" | "mixture" | "mixbsdf" | "blendbsdf" | "layered" => "write `type = \"mix\"` with `materials` and `weights`";
    MATERIAL, "subsurface" | "sss" | "translucent" | "skin" | "wax" => "write `type = \"principled\"` with `subsurface_weight = 1` and `subsurface_radius`";
    MATERIAL, "null" | "volume" | "boundary" => "give the object `medium = \"NAME\"`; as a material it is `type = \"interface\"` with `interior`";
    // Lights.
    LIGHT, "sun" | "distant" | "directionallight" | "sunlight" | "parallel" => "write `type = \"directional\"` with `from = [x, y, z]`";
    LIGHT, "area" | "arealight" | "rectarealight" | "quad" | "diffuse" => "write `type = \"rectangle\"` with `center`, `edge_u` and `edge_v`, or `type = \"disk\"` or `\"sphere\"`";
    LIGHT, "pointlight" | "omni" | "bulb" | "lightsource" | "lamp" => "write `type = \"point\"` with `position`";
    LIGHT, "spotlight" | "cone" => "write `type = \"spot\"` with `position`, `look_at` and `angle`";
    LIGHT, "infinite" | "envmap" | "hdri" | "hdr" | "dome" | "domelight" | "world" | "skybox" | "image" | "ibl" | "skydome" => "write `type = \"environment\"` with `file = \"FILE\"`";
    LIGHT, "constant" | "background" | "uniform" => "write `[background]` with `color` for light from all directions, or `type = \"ambient\"` for the constant of `classic`";
    LIGHT, "ambientlight" | "hemisphere" | "hemispherelight" => "write `type = \"ambient\"` with `color`, or `[background]` with `color` and `zenith`";
    LIGHT, "daylight" | "sunsky" | "nishita" | "atmosphere" => "write `type = \"sky\"` with `elevation` and `azimuth`";
    LIGHT, "mesh" | "emissive" | "emitter" | "goniometric" | "photometric" | "ies" => "an object emits light with `material = { type = \"emissive\" }`; an IES file belongs to `type = \"point\"` or `\"spot\"` as `ies = \"FILE\"`";
    // Cameras.
    CAMERA, "perspective" | "perspectivecamera" | "persp" => "write `type = \"pinhole\"` with `fov`";
    CAMERA, "ortho" | "orthographiccamera" | "parallel" => "write `type = \"orthographic\"` with `viewport`";
    CAMERA, "thinlens" | "dof" | "lens" => "write `type = \"thin-lens\"` with `lens_radius` and `focus_distance`";
    CAMERA, "panorama" | "panoramic" | "spherical" | "environment" | "equirect" | "omnidirectional" => "write `type = \"equirectangular\"`";
    // Integrators.
    INTEGRATOR, "pathtracer" | "pathtracing" | "pt" | "cycles" | "volpath" | "unidirectional" | "physical" => "write `type = \"path\"`";
    INTEGRATOR, "bdpt" | "vcm" | "sppm" | "photonmap" | "photonmapping" | "mlt" | "ptracer" => "write `type = \"path\"` with `caustics = \"full\"`";
    INTEGRATOR, "whitted" | "raytracer" | "raytracing" | "raytrace" | "phong" | "pov" | "povray" => "write `type = \"classic\"`";
    INTEGRATOR, "directlighting" | "directillumination" => "write `type = \"direct\"`";
    INTEGRATOR, "ao" | "ambientocclusion" | "occlusion" => "write `type = \"ambient-occlusion\"`";
    INTEGRATOR, "normal" | "aov" => "write `type = \"normals\"`; `turner list integrators` lists the other views";
    INTEGRATOR, "denoise" => "write `denoise = \"on\"` in `[film]`";
    // Textures.
    TEXTURE, "checker" | "checkered" | "checkers" | "checkeredtexture" => "write `type = \"checkerboard\"` with `even` and `odd`";
    TEXTURE, "bitmap" | "imagemap" | "imagetexture" | "picture" | "file" => "write `type = \"image\"` with `file = \"FILE\"`";
    TEXTURE, "fbm" | "turbulence" | "musgrave" | "bozo" | "clouds" | "wrinkled" => "write `type = \"noise\"` with `low` and `high`";
    TEXTURE, "ramp" | "colorramp" | "gradientramp" => "write `type = \"gradient\"` with `from` and `to`, or `stops`";
    TEXTURE, "solid" | "color" | "uniform" => "write `type = \"constant\"` with `color`";
    TEXTURE, "scale" => "write `type = \"multiply\"` with `a` and `b`";
    TEXTURE, "mesh" | "meshattribute" | "vertexcolors" => "write `type = \"vertex-color\"`";
    // Media.
    MEDIUM, "fog" | "uniform" | "constant" | "scatter" | "absorption" => "write `type = \"homogeneous\"` with `extinction` and `albedo`";
    MEDIUM, "heterogeneous" | "nanovdb" | "vdb" | "openvdb" | "gridvolume" | "uniformgrid" => "write `type = \"grid\"` with `file`";
    MEDIUM, "cloud" => "write `type = \"smoke\"`";
    // AOVs.
    AOV, "n" | "normals" | "shnormal" | "shadingnormal" | "worldnormal" | "denoisingnormal" | "nn" => "write `normal`; `camera_normal` has the axes of the camera";
    AOV, "ng" | "geonormal" | "truenormal" | "facenormal" => "write `geometric_normal`";
    AOV, "diffusecolor" | "diffcol" | "denoisingalbedo" | "basecolor" | "color" | "diffuse" | "diffusefilter" | "glossycolor" => "write `albedo`";
    AOV, "z" | "zdepth" | "mist" | "depthz" | "zbuffer" | "denoisingdepth" | "dd" | "dd.y" | "dd.y:depth" => "write `depth`; `distance` is measured along the ray";
    AOV, "p" | "pos" | "pp" | "worldposition" | "pworld" | "pref" => "write `position`";
    AOV, "st" | "texcoord" | "texturecoordinates" | "uvs" => "write `uv`";
    AOV, "motionvector" | "motionvectors" | "vector" | "velocity" | "speed" => "write `motion`: pixels while the shutter is open";
    AOV, "objectindex" | "indexob" | "id" | "ids" | "shapeindex" | "primindex" => "write `object_id`";
    AOV, "materialindex" | "indexma" | "matid" => "write `material_id`";
    AOV, "cryptomatte" | "crypto" => "write `crypto_object`, `crypto_material` or `crypto_asset`";
    AOV, "noise" | "stderr" => "write `error`, or `variance`";
    AOV, "samplevariance" | "luminancevariance" => "write `variance`";
    AOV, "heatmap" | "rays" | "raycount" | "rendertime" | "time" | "debugsamplecount" => "write `cost`: the number of rays per sample";
    AOV, "lightgroup" | "lights" | "lightselect" | "lightmix" | "rgbalights" => "write `light_groups`: a layer for each `light_group` of the scene";
    AOV, "shadowcatcher" | "shadows" | "shadowmatte" => "write `shadow`, with `shadow_catcher = true` in an object";
    AOV, "emit" | "emissive" | "env" | "environment" | "selfillum" => "write `emission`";
    AOV, "diffusedirect" | "diffdir" | "glossydirect" | "glossdir" | "directlight" | "lighting" => "write `direct`";
    AOV, "diffuseindirect" | "diffind" | "glossyindirect" | "glossind" | "gi" | "indirectlight" => "write `indirect`";
    AOV, "beauty" | "combined" | "rgb" | "rgba" | "alpha" | "opacity" => "the colour and its alpha are always there: omit it";
    AOV, "ao" | "ambientocclusion" | "wireframe" => "this is an integrator of its own: `turner list integrators`";
};
