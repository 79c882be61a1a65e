//! The scene that the camera records.
//!
//! Fixed objects are drawn once (`backdrop`); the tail ([`skin`]), its marks ([`mark`]) and the lamp are drawn into every frame, and the
//! sensor adds uneven illumination and noise. Marks, grid and board are filled with exact pixel coverage through the full lens model,
//! because tracks are compared with them.

pub(crate) mod backdrop;
pub(crate) mod board;
pub(crate) mod canvas;
pub(crate) mod glints;
pub(crate) mod letters;
pub mod mark;
mod raster;
pub(crate) mod sensor;
pub mod skin;

pub use canvas::Canvas;
