//! Sets pictures beside their references: one row each, ours, the reference, and the difference (blue below, red above).
//!
//! `cargo run --release --example contact_sheet -- sheet.png ours.exr reference.exr [more pairs]` takes seconds. Both pictures
//! of a row get the exposure that puts the reference's 95th percentile at 0.8; the difference is relative to the brighter one,
//! full color at 50 %. A reference that is larger is averaged to the size of ours; each is shrunk to tiles of 256 pixels. What
//! `compare` finds is printed.
//!
//! `contact_sheet sheet.png alone a.exr b.exr …` lays pictures that have no reference three to a row.

use std::error::Error;
use std::path::Path;

use image::{Rgb, RgbImage};
use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::read_exr;
use photonfarm::evaluation::compare;

const TILE: u32 = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [sheet, pictures @ ..] = arguments.as_slice() else { return Err("name the sheet and pictures".into()) };
    let rows = match pictures {
        [mode, alone @ ..] if mode == "alone" => alone.chunks(3).map(row_alone).collect::<Result<Vec<_>, _>>()?,
        pairs if !pairs.is_empty() && pairs.len().is_multiple_of(2) => {
            pairs.chunks(2).map(|pair| row(&pair[0], &pair[1])).collect::<Result<Vec<_>, _>>()?
        }
        _ => return Err("pictures come in pairs: ours.exr reference.exr".into()),
    };
    let height: u32 = rows.iter().map(RgbImage::height).sum();
    let mut all = RgbImage::new(3 * TILE, height);
    let mut top = 0;
    for row in rows {
        image::imageops::replace(&mut all, &row, 0, i64::from(top));
        top += row.height();
    }
    all.save(sheet)?;
    Ok(())
}

fn row(ours: &str, reference: &str) -> Result<RgbImage, Box<dyn Error>> {
    let (name, ours, reference) = (ours, read_exr(Path::new(ours))?, read_exr(Path::new(reference))?);
    let reference = shrunk(&reference, reference.width.min(ours.width));
    match compare(&ours, &reference, None) {
        Ok(found) => println!("{name}: mean {:+.2} %, relMSE {:.4}", 100.0 * found.bias, found.relmse),
        Err(problem) => println!("{name}: {problem}"),
    }
    let (ours, reference) = (tile(&ours), tile(&reference));
    if ours.height != reference.height {
        return Err(format!("the pictures of a pair have {} and {} rows", ours.height, reference.height).into());
    }
    let exposure = 0.8 / percentile(&reference);
    let mut row = RgbImage::new(3 * TILE, ours.height);
    for y in 0..ours.height {
        for x in 0..TILE {
            let index = (y * TILE + x) as usize;
            let (a, b) = (ours.radiance[index], reference.radiance[index]);
            row.put_pixel(x, y, shown(a, exposure));
            row.put_pixel(TILE + x, y, shown(b, exposure));
            row.put_pixel(2 * TILE + x, y, difference(a, b));
        }
    }
    Ok(row)
}

/// Pictures side by side, each with an exposure of its own.
fn row_alone(pictures: &[String]) -> Result<RgbImage, Box<dyn Error>> {
    let tiles = pictures
        .iter()
        .map(|file| Ok(tile(&read_exr(Path::new(file))?)))
        .collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    let height = tiles.iter().map(|tile| tile.height).max().unwrap_or(0);
    let mut row = RgbImage::new(3 * TILE, height);
    for (column, tile) in tiles.iter().enumerate() {
        let exposure = 0.8 / percentile(tile);
        for (index, pixel) in tile.radiance.iter().enumerate() {
            let (x, y) = (index as u32 % TILE, index as u32 / TILE);
            row.put_pixel(column as u32 * TILE + x, y, shown(*pixel, exposure));
        }
    }
    Ok(row)
}

fn tile(picture: &Picture) -> Picture {
    shrunk(picture, TILE)
}

/// Means over the pixels that fall into each pixel of a picture of another width.
fn shrunk(picture: &Picture, width: u32) -> Picture {
    let height = (width * picture.height).div_ceil(picture.width).max(1);
    let range = |place: u32, of: u32, size: u32| {
        let first = place * size / of;
        first..((place + 1) * size / of).max(first + 1).min(size)
    };
    let mut pixels = Vec::with_capacity((width * height) as usize);
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for source_y in range(y, height, picture.height) {
                for source_x in range(x, width, picture.width) {
                    let radiance = picture.radiance[(source_y * picture.width + source_x) as usize];
                    (0..3).for_each(|channel| sum[channel] += radiance[channel]);
                    count += 1.0;
                }
            }
            pixels.push(sum.map(|sum: f32| sum / count));
        }
    }
    Picture { width, height, radiance: pixels }
}

fn percentile(tile: &Picture) -> f32 {
    let mut values: Vec<f32> = tile.radiance.iter().map(|pixel| pixel.iter().sum::<f32>() / 3.0).collect();
    values.sort_by(f32::total_cmp);
    values[values.len() * 95 / 100].max(f32::MIN_POSITIVE)
}

fn byte(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

fn shown(radiance: [f32; 3], exposure: f32) -> Rgb<u8> {
    Rgb(radiance.map(|channel| byte(channel * exposure)))
}

fn difference(ours: [f32; 3], reference: [f32; 3]) -> Rgb<u8> {
    let mean = |pixel: [f32; 3]| pixel.iter().sum::<f32>() / 3.0;
    let (a, b) = (mean(ours), mean(reference));
    let relative = (a - b) / a.max(b).max(f32::MIN_POSITIVE);
    let strength = (relative.abs() * 2.0).min(1.0);
    let faded = byte(1.0 - strength);
    if relative > 0.0 { Rgb([255, faded, faded]) } else { Rgb([faded, faded, 255]) }
}
