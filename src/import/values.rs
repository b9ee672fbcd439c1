//! How values are written as text.

use crate::scene::description::Value;

/// The problem and the remedy of a value that cannot be read.
pub(super) type Refusal = (String, &'static str);

/// At most 60 characters of a user's text, quoted, for an error.
pub(super) fn shown(text: &str) -> String {
    let mut start: String = text.chars().take(60).collect();
    if start.len() < text.len() {
        start.push('…');
    }
    format!("{start:?}")
}

/// A number; `nan` and `inf` are numbers here.
pub(super) fn float(text: &str) -> Result<f64, Refusal> {
    text.trim().parse().map_err(|_| (format!("{} is not a number", shown(text)), "write a number such as 0.5 or 1e-3"))
}

/// A whole number.
pub(super) fn integer(text: &str) -> Result<i64, Refusal> {
    text.trim().parse().map_err(|_| (format!("{} is not an integer", shown(text)), "write a whole number such as 8"))
}

/// `true` or `false`.
pub(super) fn boolean(text: &str) -> Result<bool, Refusal> {
    match text.trim().to_ascii_lowercase().as_str() {
        "true" => Ok(true),
        "false" => Ok(false),
        _ => Err((format!("{} is not a boolean", shown(text)), "write true or false")),
    }
}

/// Numbers that are separated by commas or spaces.
pub(super) fn floats(text: &str) -> Result<Vec<f64>, Refusal> {
    text.split(|c: char| c == ',' || c.is_whitespace()).filter(|part| !part.is_empty()).map(float).collect()
}

/// Three numbers; a single one stands for all three.
pub(super) fn triple(text: &str) -> Result<[f64; 3], Refusal> {
    spread(&floats(text)?).ok_or_else(|| (format!("{} is not three numbers", shown(text)), "write it as \"x, y, z\""))
}

/// Three numbers from a list of three or one.
pub(super) fn spread(numbers: &[f64]) -> Option<[f64; 3]> {
    match *numbers {
        [all] => Some([all; 3]),
        [x, y, z] => Some([x, y, z]),
        _ => None,
    }
}

/// A linear color: three numbers, one for grey, or `#rrggbb` in sRGB.
pub(super) fn rgb(text: &str) -> Result<Value, Refusal> {
    let refusal = || {
        let remedy = "write \"red, green, blue\" in linear Rec. 709, one number for grey, or #rrggbb in sRGB";
        (format!("{} is not a color", shown(text)), remedy)
    };
    let numbers = match text.trim().strip_prefix('#') {
        None => spread(&floats(text)?),
        Some(digits) if digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()) => {
            let code = u32::from_str_radix(digits, 16).map_err(|_| refusal())?;
            Some([16, 8, 0].map(|shift| linear_from_srgb(f64::from(code >> shift & 0xff) / 255.0)))
        }
        Some(_) => None,
    };
    numbers.map(Value::Rgb).ok_or_else(refusal)
}

/// The linear value of an encoded one: IEC 61966-2-1.
pub(super) fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}
