//! Which objects and materials the camera sees first, and how much of each pixel they cover: by the rays of
//! [`first_surface`](super::first_surface), so that mattes fit to its layers.

use rayon::prelude::*;

use super::first_surface::first_hits;
use crate::estimate::picture_files::{Matte, Mattes};
use crate::scene::Scene;
use crate::scene::names::UniqueNames;

/// How much of every pixel objects and materials cover. Runs on the calling rayon pool.
pub fn mattes(scene: &Scene) -> Mattes {
    let names = [scene.names.unique_objects(), scene.names.unique_materials()];
    let rows: Vec<[Matte; 2]> =
        (0..scene.height).into_par_iter().map(|row| mattes_of_row(scene, row, &names)).collect();
    let [objects, materials] = names.map(|names| Matte { names: names.names, ..Matte::default() });
    let mut mattes = Mattes { objects, materials };
    for [objects, materials] in &rows {
        mattes.objects.append(objects);
        mattes.materials.append(materials);
    }
    mattes
}

/// Those of a row of pixels, without names.
fn mattes_of_row(scene: &Scene, row: u32, names: &[UniqueNames; 2]) -> [Matte; 2] {
    let [mut objects, mut materials] = [Matte::default(), Matte::default()];
    for pixel in row * scene.width..(row + 1) * scene.width {
        let things = |(_, hit)| (scene.geometry.object(&hit), hit.shape.material as usize);
        let (objects_met, materials_met): (Vec<usize>, Vec<usize>) = first_hits(scene, pixel).map(things).unzip();
        objects.push_pixel(&mut names[0].names_of(&objects_met));
        materials.push_pixel(&mut names[1].names_of(&materials_met));
    }
    [objects, materials]
}
