mod quality;
pub use quality::scaled_jacobian;
