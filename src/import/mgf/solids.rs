//! The geometric entities of MGF: `f`, `fh`, `sph`, `cyl`, `cone`, `ring`, `torus`, `prism`.
//!
//! Spheres, cylinders and full rings are shapes of their own; the others become triangles. Round outlines get 72 corners: a chord then lies
//! within 0.1 % of the radius, less than a pixel for an object 1000 pixels wide; shading is smooth by its normals. A
//! negative radius or length turns the inside out.

use glam::{DMat4, DVec3};

use super::super::draft::Draft;
use super::super::values::shown;
use super::context::Contexts;
use super::stage::{Placed, Stage, Vertex};
use super::text::Entity;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;

/// Corners of a circle.
const CORNERS: u32 = 72;
/// Corners round the tube of a torus, which is smaller.
const TUBE_CORNERS: u32 = 36;

/// One geometric entity, with all that it depends on.
pub(super) struct Solid<'a> {
    pub entity: &'a Entity<'a>,
    pub vertices: &'a Contexts<Vertex>,
    pub placed: &'a Placed,
    pub surface: usize,
    pub stage: &'a mut Stage,
}

/// Two axes across a direction: right-handed with it.
fn axes(direction: DVec3) -> (DVec3, DVec3) {
    let u = direction.any_orthonormal_vector();
    (u, direction.cross(u))
}

/// The direction at corner `index` of a circle of `count`.
fn around((u, v): (DVec3, DVec3), index: f64, count: u32) -> DVec3 {
    let (sine, cosine) = libm::sincos(std::f64::consts::TAU * index / f64::from(count));
    u * cosine + v * sine
}

impl Solid<'_> {
    /// Adds it to the stage.
    pub(super) fn add(mut self) -> Result<(), SceneError> {
        match self.entity.keyword {
            "f" => self.face(),
            "fh" => self.face_with_holes(),
            "sph" => self.sphere(),
            "cyl" => self.cylinder(),
            "cone" => self.cone(),
            "ring" => self.ring(),
            "torus" => self.torus(),
            _ => self.prism(),
        }
    }

    fn vertex(&self, index: usize) -> Result<Vertex, SceneError> {
        self.vertices.find(self.entity.word(index), self.entity)
    }

    /// The vertex at `index` in the world.
    fn corner(&self, index: usize) -> Result<Vertex, SceneError> {
        self.vertex(index).map(|vertex| self.placed.vertex(vertex))
    }

    /// The vertex at `index` in the world, which needs a normal.
    fn oriented(&self, index: usize) -> Result<Vertex, SceneError> {
        let vertex = self.corner(index)?;
        if vertex.normal != DVec3::ZERO {
            return Ok(vertex);
        }
        let problem = format!("vertex {} has no normal", shown(self.entity.word(index)));
        Err(self.entity.error(problem, format!("give it one with \"n\": a {} needs it", self.entity.keyword)))
    }

    fn face(&mut self) -> Result<(), SceneError> {
        self.entity.check_count(3, usize::MAX, "f v1 v2 v3 …")?;
        let outline = (0..self.entity.words.len()).map(|index| self.vertex(index)).collect::<Result<_, _>>()?;
        self.polygon(vec![outline])
    }

    fn face_with_holes(&mut self) -> Result<(), SceneError> {
        let mut loops = vec![Vec::new()];
        for (index, word) in self.entity.words.iter().enumerate() {
            match (*word, loops.last_mut()) {
                ("-", _) => loops.push(Vec::new()),
                (_, Some(outline)) => outline.push(self.vertex(index)?),
                _ => {}
            }
        }
        if loops.iter().any(|outline| outline.len() < 3) {
            return Err(self
                .entity
                .error("an outline has fewer than 3 corners", "write \"fh v1 v2 v3 … - h1 h2 h3 …\""));
        }
        self.polygon(loops)
    }

    /// Places a polygon. Mirrors turn round the order of corners.
    fn polygon(&mut self, mut loops: Vec<Vec<Vertex>>) -> Result<(), SceneError> {
        for outline in &mut loops {
            outline.iter_mut().for_each(|vertex| *vertex = self.placed.vertex(*vertex));
            if self.placed.mirrored {
                outline.reverse();
            }
        }
        self.stage.polygon(self.surface, &loops, self.entity)
    }

    /// A number in the world's scale that is not 0, and whether it is negative.
    fn radius(&self, index: usize) -> Result<(f64, bool), SceneError> {
        let radius = self.entity.number(index)? * self.placed.scale;
        if radius == 0.0 {
            return Err(self.entity.error("the size is 0", "give a number that is not 0"));
        }
        Ok((radius.abs(), radius < 0.0))
    }

    fn sphere(&mut self) -> Result<(), SceneError> {
        self.entity.check_count(2, 2, "sph center radius")?;
        let (center, (radius, inward)) = (self.corner(0)?.position, self.radius(1)?);
        let shape = Draft::new(PluginClass::Shape, "sphere", &self.entity.location());
        let shape = shape.with_point("center", center).with_float("radius", radius).with_flag("flip_normals", inward);
        self.stage.shape(self.surface, shape, (center, radius), self.entity)
    }

    fn cylinder(&mut self) -> Result<(), SceneError> {
        self.entity.check_count(3, 3, "cyl v1 radius v2")?;
        let (start, (radius, inward), end) = (self.corner(0)?.position, self.radius(1)?, self.corner(2)?.position);
        if start == end {
            return Err(self.entity.error("the cylinder has no height", "give two vertices that differ"));
        }
        let shape = Draft::new(PluginClass::Shape, "cylinder", &self.entity.location());
        let shape = shape.with_point("p0", start).with_point("p1", end);
        let shape = shape.with_float("radius", radius).with_flag("flip_normals", inward);
        let ball = (0.5 * (start + end), 0.5 * (end - start).length() + radius);
        self.stage.shape(self.surface, shape, ball, self.entity)
    }

    fn cone(&mut self) -> Result<(), SceneError> {
        self.entity.check_count(4, 4, "cone v1 radius1 v2 radius2")?;
        let ends = [self.corner(0)?.position, self.corner(2)?.position];
        let radii = [self.entity.number(1)?, self.entity.number(3)?].map(|radius| radius * self.placed.scale);
        if radii == [0.0; 2] || radii[0] * radii[1] < 0.0 {
            let problem = format!("{} and {} are no radii of a cone", self.entity.word(1), self.entity.word(3));
            return Err(self.entity.error(problem, "give two of the same sign, of which one may be 0"));
        }
        let Some(axis) = (ends[1] - ends[0]).try_normalize() else {
            return Err(self.entity.error("the cone has no height", "give two vertices that differ, or use a ring"));
        };
        let inward = radii[0] + radii[1] < 0.0;
        let radii = radii.map(f64::abs);
        let (height, frame) = ((ends[1] - ends[0]).length(), axes(axis));
        let vertex = |column: u32, row: u32| {
            let (row, column) = (row as usize, f64::from(column));
            // The tip has a normal for each triangle, that in the middle of it.
            let facing = match radii[row] == 0.0 {
                true => around(frame, if row == 0 { column + 0.5 } else { column - 0.5 }, CORNERS),
                false => around(frame, column, CORNERS),
            };
            let normal = (facing * height + axis * (radii[0] - radii[1])).normalize_or_zero();
            Vertex { position: ends[row] + around(frame, column, CORNERS) * radii[row], normal }
        };
        self.stage.grid(self.surface, [CORNERS, 1], inward, self.entity, vertex)
    }

    fn ring(&mut self) -> Result<(), SceneError> {
        self.entity.check_count(3, 3, "ring center inner_radius outer_radius")?;
        let Vertex { position: center, normal } = self.oriented(0)?;
        let radii = [self.entity.number(1)?, self.entity.number(2)?].map(|radius| radius * self.placed.scale);
        if !(radii[0] >= 0.0 && radii[1] > radii[0]) {
            let problem = format!("there is no ring between radii {} and {}", self.entity.word(1), self.entity.word(2));
            return Err(self.entity.error(problem, "give an inner radius of at least 0 and a larger outer one"));
        }
        let frame = axes(normal);
        if radii[0] == 0.0 {
            let columns = [frame.0, frame.1, normal].map(|axis| (axis * radii[1]).extend(0.0));
            let to_world = DMat4::from_cols(columns[0], columns[1], columns[2], center.extend(1.0));
            let shape =
                Draft::new(PluginClass::Shape, "disk", &self.entity.location()).with_transform("to_world", to_world);
            return self.stage.shape(self.surface, shape, (center, radii[1]), self.entity);
        }
        // Counter-clockwise along the circle and then inwards.
        let vertex = |column: u32, row: u32| Vertex {
            position: center + around(frame, f64::from(column), CORNERS) * radii[1 - row as usize],
            normal,
        };
        self.stage.grid(self.surface, [CORNERS, 1], false, self.entity, vertex)
    }

    fn torus(&mut self) -> Result<(), SceneError> {
        self.entity.check_count(3, 3, "torus center inner_radius outer_radius")?;
        let Vertex { position: center, normal: axis } = self.oriented(0)?;
        let radii = [self.entity.number(1)?, self.entity.number(2)?].map(|radius| radius * self.placed.scale);
        if radii[0] * radii[1] < 0.0 || radii[1].abs() <= radii[0].abs() {
            let problem =
                format!("there is no torus between radii {} and {}", self.entity.word(1), self.entity.word(2));
            return Err(self.entity.error(problem, "give two radii of the same sign, the outer one larger"));
        }
        let [inner, outer] = radii.map(f64::abs);
        let (ring, tube) = (0.5 * (inner + outer), 0.5 * (outer - inner));
        let frame = axes(axis);
        let vertex = |column: u32, row: u32| {
            let radial = around(frame, f64::from(column), CORNERS);
            let normal = around((radial, axis), f64::from(row), TUBE_CORNERS);
            Vertex { position: center + radial * ring + normal * tube, normal }
        };
        self.stage.grid(self.surface, [CORNERS, TUBE_CORNERS], radii[1] < 0.0, self.entity, vertex)
    }

    /// One end is given; the other lies against its normal. Sides are shaded by the vertices' normals, ends are flat.
    fn prism(&mut self) -> Result<(), SceneError> {
        self.entity.check_count(4, usize::MAX, "prism v1 v2 v3 … length")?;
        let count = self.entity.words.len() - 1;
        let end = (0..count).map(|index| self.vertex(index)).collect::<Result<Vec<_>, _>>()?;
        let length = self.entity.number(count)?;
        if length == 0.0 {
            return Err(self.entity.error("the prism has no length", "give a length that is not 0"));
        }
        let area =
            end.windows(2).map(|pair| (pair[0].position - end[0].position).cross(pair[1].position - end[0].position));
        let Some(normal) = area.sum::<DVec3>().try_normalize() else {
            return Err(self.entity.error("the end of the prism has no area", "give corners that span a plane"));
        };
        let moved: Vec<Vertex> = end.iter().map(|v| Vertex { position: v.position - normal * length, ..*v }).collect();
        let flat = |corners: &[Vertex]| corners.iter().map(|v| Vertex { normal: DVec3::ZERO, ..*v }).collect();
        self.polygon(vec![flat(&end)])?;
        self.polygon(vec![flat(&moved.iter().rev().copied().collect::<Vec<_>>())])?;
        for index in 0..count {
            let before = (index + count - 1) % count;
            self.polygon(vec![vec![moved[index], end[index], end[before], moved[before]]])?;
        }
        Ok(())
    }
}
