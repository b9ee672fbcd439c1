//! Writing down parameters of plugins.

use glam::DMat4;

use super::super::draft::Draft;
use crate::scene::description::Value;

/// The types of parameters, for each of which there is one way to give it.
impl Draft {
    pub(in super::super) fn with_float(self, name: &str, number: f64) -> Self {
        self.with(name, Value::Float(number))
    }

    pub(in super::super) fn with_flag(self, name: &str, flag: bool) -> Self {
        self.with(name, Value::Boolean(flag))
    }

    pub(in super::super) fn with_text(self, name: &str, text: &str) -> Self {
        self.with(name, Value::String(text.to_owned()))
    }

    pub(in super::super) fn with_rgb(self, name: &str, rgb: [f64; 3]) -> Self {
        self.with(name, Value::Rgb(rgb))
    }

    pub(in super::super) fn with_point(self, name: &str, point: glam::DVec3) -> Self {
        self.with(name, Value::Vector(point.to_array()))
    }

    pub(in super::super) fn with_transform(self, name: &str, matrix: DMat4) -> Self {
        self.with(name, Value::Transform(matrix))
    }
}
