//! The scene: what the camera sees of the bench, from the grid below to the lamp beside.
//!
//! What never moves is drawn once ([`backdrop`]); the tail ([`skin`]), its marks ([`paint`]) and the lamp are drawn into
//! every frame, and the sensor adds uneven light and noise. Marks, grid and board are filled with the exact area of
//! each pixel that they cover, through the full lens, because tracks are judged against them.
//!
//! Stands on: the camera, `ab_glyph_rasterizer` (through `canvas`). Never knows: physics, a file, a trial.

pub mod backdrop;
pub mod board;
pub mod canvas;
pub mod glints;
pub mod letters;
pub mod paint;
pub mod sensor;
pub mod skin;

pub use canvas::Canvas;
