//! Views: what an eye can see, set up for drawing.
//!
//! A [`Viewer`] opens views one after the other and lends its memory to the last one. A view can be drawn by several
//! threads, each with a [`Canvas`](crate::Canvas) of its own.

use std::sync::Arc;

use fearless_simd::{Level, dispatch};
use glam::DVec3;
use scene::SurfaceId;

use crate::drawable::{Drawable, Strategy};
use crate::eye::{Eye, Standpoint};
use crate::hemicube::{self, FACES};
use crate::look_up::Locators;
use crate::rays::Bvh;
use crate::spans::Projection;
use crate::specks::{self, Clusters, Specks};
use crate::{Frame, Window};

/// Opens views of a scene, one after the other.
#[derive(Clone, Debug)]
pub struct Viewer<'a> {
    drawable: Arc<Drawable<'a>>,
    level: Level,
    projection: Projection,
    specks: Specks,
}

/// What an eye sees, through any window of its frame.
#[derive(Clone, Copy, Debug)]
pub struct View<'v> {
    pub(crate) at: Standpoint<'v>,
    pub(crate) locators: &'v Locators,
    pub(crate) projection: &'v Projection,
    /// Where rays are cast; nothing is set up then.
    pub(crate) bvh: Option<&'v Bvh>,
}

/// What an eye on a surface sees through the faces of a hemicube.
#[derive(Clone, Copy, Debug)]
pub struct HemicubeView<'v> {
    pub(crate) view: View<'v>,
    /// What is drawn besides the view's pieces.
    pub(crate) specks: Option<(&'v Specks, &'v Clusters)>,
    pub(crate) windows: [Window; FACES],
}

impl<'a> Viewer<'a> {
    /// A viewer of a scene.
    pub fn new(drawable: &Arc<Drawable<'a>>) -> Self {
        Self {
            drawable: Arc::clone(drawable),
            level: Level::new(),
            projection: Projection::new(&drawable.geometry),
            specks: Specks::default(),
        }
    }

    /// What it views.
    pub fn drawable(&self) -> &Arc<Drawable<'a>> {
        &self.drawable
    }

    /// All that an eye sees, to be drawn into windows of so many pixels in all, about: where they are few and the
    /// scene's pieces many, rays are cast.
    pub fn view(&mut self, eye: &Eye, pixels: usize) -> View<'_> {
        let drawable = &*self.drawable;
        let at = Standpoint::new(&drawable.geometry, eye);
        let bvh = drawable.rays_for(pixels);
        if bvh.is_none() {
            self.projection.set(&at);
        }
        View::new(drawable, at, &self.projection, bvh)
    }

    /// The same of some regions alone, as if nothing else were there.
    pub fn view_of(&mut self, eye: &Eye, regions: impl Iterator<Item = u32>) -> View<'_> {
        let drawable = &*self.drawable;
        let at = Standpoint::new(&drawable.geometry, eye);
        self.projection.set_some(&at, regions);
        View::new(drawable, at, &self.projection, None)
    }

    /// What a hemicube of a resolution sees that stands on the surface `own`, if on any.
    pub fn hemicube(
        &mut self,
        resolution: u32,
        frame: &Frame,
        own: impl Into<Option<SurfaceId>>,
    ) -> HemicubeView<'_> {
        let drawable = &*self.drawable;
        let at = Standpoint::new(&drawable.geometry, &Eye::with_horizon(frame, own));
        let is_cast = drawable.strategy == Strategy::Rays;
        let bvh = drawable.bvh.as_ref().filter(|_| is_cast);
        let (projection, specks) = (&mut self.projection, &mut self.specks);
        if let Some(clusters) = &drawable.clusters {
            dispatch!(self.level, simd => specks::set(
                simd, &at, clusters, resolution, specks, projection
            ));
        } else if bvh.is_none() {
            projection.set(&at);
        }
        HemicubeView {
            view: View::new(drawable, at, projection, bvh),
            specks: drawable.clusters.as_ref().map(|c| (&*specks, c)),
            windows: hemicube::windows(resolution),
        }
    }
}

impl<'v> View<'v> {
    fn new(
        drawable: &'v Drawable<'v>,
        at: Standpoint<'v>,
        projection: &'v Projection,
        bvh: Option<&'v Bvh>,
    ) -> Self {
        Self {
            at,
            locators: &drawable.locators,
            projection,
            bvh,
        }
    }
}

impl View<'_> {
    /// True where one piece hides all of some polygons, of which there is one at least; their corners are relative to
    /// the eye, in its frame, metres. Where rays are cast nothing is known that hides.
    pub fn hides(&self, polygons: &[Vec<DVec3>]) -> bool {
        self.bvh.is_none() && self.projection.hides(polygons)
    }
}

impl HemicubeView<'_> {
    /// The windows of its faces.
    pub fn windows(&self) -> &[Window; FACES] {
        &self.windows
    }
}
