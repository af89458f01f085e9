//! Options of other programs with Turner's equivalents. For words in scenes see [`turner::schema::foreign`].

/// Options with one remedy.
pub(crate) struct ForeignOption {
    /// Without dashes.
    pub(crate) words: &'static [&'static str],
    /// What to write instead, with code in backquotes.
    pub(crate) remedy: &'static str,
}

macro_rules! words {
    ($($($word:literal)|+ => $remedy:literal;)*) => {
        &[$(ForeignOption { words: &[$($word),+], remedy: $remedy },)*]
    };
}

/// The table.
pub(crate) const OPTIONS: &[ForeignOption] = words! {
    "spp" | "sample" | "sample-count" | "samples-per-pixel" | "rays" | "aa-samples" | "pixelsamples" => "write `--samples 64`";
    "size" | "resolution" | "res" | "dimensions" | "geometry" => "write `--width 640 --height 480`";
    "w" | "xres" | "image-width" => "write `--width 640`";
    "hres" | "yres" | "image-height" => "write `--height 480`";
    "out" | "outfile" | "output-file" | "o-file" | "save" | "image" | "file" => "write `-o FILE`";
    "draft" | "fast" | "quick" | "preset" => "write `--quality draft`; `turner watch` renders again after each change";
    "interactive" | "gui" | "live" => "`turner studio SCENE` opens a window; `turner watch SCENE` renders again after each change";
    "reload" => "`turner watch SCENE` renders again after each change";
    "aovs" | "pass" | "passes" | "channel" | "render-pass" => "write `--aov albedo,normal,depth`: `turner list aovs`";
    "dof" | "aperture" | "f-stop" | "lens" => "write `--fstop 2.8`, and `--focus 5` or `--focus object`";
    "focal-distance" | "focus-distance" => "write `--focus 5`, or `--focus object`";
    "focal-length" | "vfov" | "field-of-view" => "write `--fov 40`, the vertical field of view in degrees";
    "eye" | "position" | "from" | "camera-position" => "write `-D camera.position=[0,1,5]`";
    "lookat" | "target" | "to" => "write `--look-at NAME` for an object, or `-D camera.look_at=[0,0,0]` for a point";
    "denoiser" | "oidn" | "optix" => "write `--denoise`: Turner has a denoiser of its own";
    "gpu" | "cuda" | "metal" | "opencl" | "hip" | "device" => "Turner renders on the CPU; `--threads` sets the number of threads";
    "engine" | "renderer" | "render-engine" | "method" | "algorithm" | "tracer" => "write `--integrator path`: `turner list integrators`";
    "path" | "pathtracer" | "path-tracing" | "pt" | "gi" | "global-illumination" => "write `--integrator path`";
    "whitted" | "raytrace" | "classic" => "write `--integrator classic`";
    "ao" => "write `--integrator ambient-occlusion`";
    "normals" | "depth-map" | "albedo" | "wireframe" => "write `--aov normal` for a channel next to the colour, or `--integrator normals` or another debug view";
    "depth" | "bounces" | "max-bounces" | "recursion" | "max-recursion" | "maxdepth" => "write `--max-depth 8`";
    "jobs" | "j" | "cpus" | "cores" | "nthreads" | "num-threads" | "workers" => "write `--threads 4`";
    "hdri" | "hdr" | "envmap" | "env" | "env-map" | "skybox" | "ibl" | "world" => "write `--environment FILE`";
    "env-intensity" | "sky-strength" => "write `--env-strength 2`";
    "bg" | "background-color" | "alpha" | "transparent" => "write `--background transparent`, or a colour";
    "gamma" | "srgb" | "color-space" => "write `-D film.transfer=srgb`";
    "tone-map" | "tone-mapping" | "tonemapping" | "view-transform" | "filmic" | "aces" => "write `--tonemap NAME`: `turner list tonemaps`";
    "ev" | "brightness" | "gain" => "write `--exposure 1`, in stops";
    "aa" | "anti-aliasing" | "antialiasing" | "supersample" => "write `--antialias monte-carlo --samples 64`";
    "region" | "window" | "crop-window" | "border" | "cropwindow" => "write `--crop X,Y,W,H`";
    "clamp" | "firefly" | "clamp-sample" => "write `--clamp-indirect 10`";
    "photons" | "photon-map" | "sppm" | "bdpt" | "vcm" => "write `--integrator path --caustics full`";
    "animation-frames" | "anim" | "start" | "frame-start" => "write `--frames 0-47`";
    "orbit" | "spin" | "rotate" => "write `--turntable 36`";
    "silent" | "q" | "no-progress" => "write `--quiet`";
    "log" | "verbose" | "v" | "progress" | "stats" => "write `--json` for events; `turner info SCENE` shows counts and memory";
    "memory" | "mem" | "mem-limit" | "max-mem" => "write `--max-memory 4G`";
    "timeout" | "time-limit" => "stop with Ctrl-C: the picture so far is saved";
    "param" | "override" | "define-key" => "write `-D KEY.PATH=VALUE`";
    "cam" | "viewpoint" => "write `--camera NAME`, or `--camera orbit:30,20`";
};

/// The remedy for an option that does not exist.
pub(crate) fn option(name: &str) -> Option<&'static str> {
    let name = name.trim_start_matches('-').split('=').next()?.to_lowercase().replace('_', "-");
    OPTIONS.iter().find(|o| o.words.contains(&name.as_str())).map(|o| o.remedy)
}
