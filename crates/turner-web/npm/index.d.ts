/** Bytes of a file. The package copies them. */
export type Bytes = Uint8Array | ArrayBuffer | ArrayBufferView;

/** A model or scene: its bytes, the text of a scene, or a scene with its files. */
export type Input = Bytes | string | {
  /** Bytes or text of each file by its name: paths in the scene name them. */
  files: Record<string, Bytes | string>;
  /** The name of the scene or model; not needed if there is only one file. */
  main?: string;
};

/** The type of the pixels, or of the file. */
export type Format = "rgba" | "linear" | "png" | "jpg" | "jpeg" | "webp" | "exr" | "hdr";

/** A value of a scene. */
export type Value = string | number | boolean | readonly Value[] | ArrayBufferView | { readonly [key: string]: Value };

/** Around a model or scene: azimuth in degrees from the front (+z) to the right, elevation in degrees above the horizon. */
export interface Orbit {
  /** `[azimuth, elevation]` or `[azimuth, elevation, distance]`; the distance in radii of the bounding sphere. */
  orbit?: readonly [number, number] | readonly [number, number, number];
  /** Degrees; 35 if it is left out. Not with `orbit`. */
  azimuth?: number;
  /** Degrees; 22 if it is left out. Not with `orbit`. */
  elevation?: number;
  /** Radii of the bounding sphere; without it the picture frames everything. Not with `orbit`. */
  distance?: number;
  /** Field of view along the shorter side of the picture, degrees. */
  fov?: number;
}

export interface Progress {
  /** From 0 to 1; it never falls. */
  fraction: number;
  /** `finishing`: all samples are there; noise is removed and the file is written. */
  stage: "reading" | "rendering" | "finishing";
}

export interface RenderOptions<F extends Format = Format> {
  /** File name of the bytes, whose extension tells their format. GLB, glTF, PLY and text need none. */
  name?: string;
  /** Pixels. One side alone keeps the aspect ratio. Models have 640 x 480 without them. */
  width?: number;
  height?: number;
  /** Samples per pixel. Models have 8 and a denoiser without this. */
  samples?: number;
  /** `path`, `direct`, `whitted`, or a debug view such as `normals` and `depth`. */
  integrator?: string;
  /** Values of the scene by key path, as in `turner -D`: `{ "film.samples": 64, "object.0.radius": 2 }`. */
  set?: Record<string, Value>;
  /** An orbit, or the text of `turner --camera`: `orbit:30,20` or the name of a camera. */
  camera?: string | Orbit;
  /** An equirectangular picture (.hdr, .exr) that is the only light besides emissive surfaces. Rotation in degrees. */
  environment?: Bytes | { bytes: Bytes; name?: string; strength?: number; rotation?: number };
  /** What `data` is; `rgba` without it. */
  format?: F;
  /** Further channels: `albedo`, `normal`, `depth`, `object_id` and so on. */
  aovs?: readonly string[];
  /** Ends the picture: the promise rejects with the signal's reason at once. */
  signal?: AbortSignal;
  /** Hears of the progress, about 20 times a second. */
  onProgress?: (progress: Progress) => void;
}

export interface Aov {
  /** Pixel by pixel, row by row from the top left, the channels of a pixel side by side. */
  data: Float32Array | Uint32Array;
  /** Their names in EXR files. */
  channels: string[];
}

/** `rgba`: 8 bits a channel, as shown. `linear`: red, green, blue and alpha of the scene as floats. Others: a file. */
export type Data<F extends Format> =
  F extends "rgba" ? Uint8ClampedArray : F extends "linear" ? Float32Array : Uint8Array;

export interface Picture<F extends Format = "rgba"> {
  width: number;
  height: number;
  format: Format;
  data: Data<F>;
  /** Those that were asked for, by name. Light groups have one each: `light.NAME`. */
  aovs: Record<string, Aov>;
  /** What was chosen, approximated or ignored in reading the files. */
  warnings: string[];
}

/** Why a picture failed. */
export class TurnerError extends Error {
  name: "TurnerError";
  /** The remedy, if one is known. */
  help?: string;
  /** The stable code: docs/reference/errors.md. */
  code?: string;
  /** The file of the scene with the error, its line and columns, from 1, and the line itself. */
  file?: string;
  line?: number;
  column?: number;
  end_column?: number;
  excerpt?: string;
}

export interface TurnerOptions {
  /** Threads that render. Without it: all of the machine. In pages that are not cross-origin isolated: one. */
  threads?: number;
  /** The module, or its address, if it is not beside the package. */
  wasm?: URL | string | WebAssembly.Module;
}

/** One session in a worker: its module and memory stay between pictures, which are rendered one after another. */
export class Turner {
  constructor(options?: TurnerOptions);
  /** Threads of the session; 0 before the first picture. */
  readonly threads: number;
  /** Bytes of the session's memory after the last picture. */
  readonly memory: number;
  /** Renders a picture. Rejects with a {@link TurnerError}, or with the reason of `signal`. */
  render<F extends Format = "rgba">(input: Input, options?: RenderOptions<F>): Promise<Picture<F>>;
  /** Ends the worker and frees its memory. Pictures that wait are rejected. */
  close(): void;
}

/** Renders a picture in a session that is kept for the next one. */
export function render<F extends Format = "rgba">(
  input: Input,
  options?: RenderOptions<F> & TurnerOptions,
): Promise<Picture<F>>;
