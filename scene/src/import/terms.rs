//! The words of a format.

/// What a format calls things, for messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    /// The colour of a material.
    pub colour: &'static str,
    /// Texture coordinates.
    pub coordinates: &'static str,
    /// What counts where a picture cannot be read.
    pub without_picture: &'static str,
}
