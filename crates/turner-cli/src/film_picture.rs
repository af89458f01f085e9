//! The picture of a film, to be saved.

use turner::film::{Denoise, Developed, DisplayTransform, Picture};
use turner::render::Renderer;
use turner_io::Save;

/// The picture of a renderer's film. Its rows are developed while it is written, so that a large picture needs no memory
/// beside its film. Debug views, whose display values may depend on all pixels, are developed as a whole.
pub(crate) enum FilmPicture<'a> {
    /// Rows of the film.
    Rows(Developed<'a>),
    /// A debug view, and how its linear values would be shown if they were colours.
    Whole(Picture, DisplayTransform),
}

impl<'a> FilmPicture<'a> {
    /// The picture so far, on `threads` threads; 0 uses all.
    pub(crate) fn new(renderer: &'a Renderer, threads: usize) -> FilmPicture<'a> {
        FilmPicture::with(renderer, threads, |threads| renderer.developed(threads))
    }

    /// The same by the fast denoiser, if the picture has one: for pictures while rendering continues.
    pub(crate) fn progress(renderer: &'a Renderer, threads: usize) -> FilmPicture<'a> {
        FilmPicture::with(renderer, threads, |threads| renderer.developed_as(Denoise::Fast, threads))
    }

    fn with(
        renderer: &'a Renderer,
        threads: usize,
        developed: impl FnOnce(usize) -> Developed<'a>,
    ) -> FilmPicture<'a> {
        let prepared = renderer.prepared();
        let desc = &prepared.view.film;
        if prepared.integrator.capabilities().debug {
            let picture = renderer.develop_with(threads);
            let transform = picture.transform(desc);
            return FilmPicture::Whole(picture, transform);
        }
        FilmPicture::Rows(developed(threads))
    }

    /// What is saved.
    pub(crate) fn samples(&self) -> &dyn Save {
        match self {
            FilmPicture::Rows(rows) => rows,
            FilmPicture::Whole(picture, _) => picture,
        }
    }

    /// How linear values become display values.
    pub(crate) fn transform(&self) -> DisplayTransform {
        match self {
            FilmPicture::Rows(rows) => rows.transform(),
            FilmPicture::Whole(_, transform) => *transform,
        }
    }

    /// Whether a debug view chose display values that are not those of the linear values.
    pub(crate) fn has_custom_display(&self) -> bool {
        match self {
            FilmPicture::Rows(_) => false,
            FilmPicture::Whole(picture, transform) => {
                transform.to_8_bits(&picture.linear, 0) != picture.display
            }
        }
    }

    /// Whether no pixel has a sample or a preview.
    pub(crate) fn is_empty(&self) -> bool {
        let missing = match self {
            FilmPicture::Rows(rows) => rows.missing,
            FilmPicture::Whole(picture, _) => picture.missing,
        };
        let (width, height) = self.samples().size();
        missing >= u64::from(width) * u64::from(height)
    }
}
