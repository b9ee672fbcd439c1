//! The part of the film in which chains look for paths.

use crate::math::Vec2;
use crate::scene::Scene;

/// A rectangle of the whole film, (0, 0) top left to (1, 1) bottom right.
#[derive(Clone, Copy, Debug)]
pub struct FilmWindow {
    low: Vec2,
    size: Vec2,
    /// One pixel.
    pixel: Vec2,
}

impl FilmWindow {
    /// All places of the film that count in the picture.
    pub fn new(scene: &Scene) -> Self {
        let film = &scene.film;
        let whole = Vec2::new(film.whole[0] as f32, film.whole[1] as f32);
        let low = Vec2::new(film.offset[0] as f32, film.offset[1] as f32);
        let high = low + Vec2::new(film.width as f32, film.height as f32);
        // A filter reaches as far to the left as to the right.
        let border = if film.samples_border { film.filter.reach(0.0).1.abs() + 1.0 } else { 0.0 };
        let (mut low, mut high) = ((low - border) / whole, (high + border) / whole);
        if scene.camera.repeats().len() > 1 {
            // Beyond the edges of a picture of all around are places that it has already.
            (low, high) = (low.max(Vec2::ZERO), high.min(Vec2::ONE));
        }
        Self { low, size: high - low, pixel: 1.0 / whole }
    }

    /// A place for two numbers in [0, 1).
    pub fn place(&self, u: [f32; 2]) -> Vec2 {
        self.low + self.size * Vec2::from_array(u)
    }

    /// The density of a uniform place, over that of one in the whole film.
    pub fn density(&self) -> f64 {
        1.0 / f64::from(self.size.x * self.size.y)
    }

    /// Whether a place lies in it.
    pub fn contains(&self, place: Vec2) -> bool {
        let within = place - self.low;
        within.cmpge(Vec2::ZERO).all() && within.cmplt(self.size).all()
    }

    /// A pixel's width and height.
    pub fn pixel(&self) -> Vec2 {
        self.pixel
    }

    /// Its area, pixels.
    pub fn pixels(&self) -> f32 {
        let size = self.size / self.pixel;
        size.x * size.y
    }
}
