//! Parameter lists: `"type name" [ values ]`, any number of times.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

use glam::DVec3;

use super::super::values::shown;
use super::text::{Token, Tokens};
use crate::scene::error::{Location, SceneError, closest_name, nearest_name, shown_number};

/// The types of parameters that are numbers.
const NUMERIC: [&str; 14] = [
    "integer",
    "float",
    "point",
    "point2",
    "point3",
    "vector",
    "vector2",
    "vector3",
    "normal",
    "normal3",
    "rgb",
    "color",
    "blackbody",
    "spectrum",
];
/// The other types; a spectrum can be both.
const OTHERS: [&str; 3] = ["bool", "string", "texture"];

/// The values of a parameter.
#[derive(Clone, Debug)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Flags(Vec<bool>),
}

/// One parameter.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub kind: String,
    pub name: String,
    pub values: Values,
    pub place: Location,
    /// Whether anybody asked for it.
    used: Cell<bool>,
}

impl Parameter {
    /// An error at this parameter.
    pub(super) fn error(&self, problem: impl AsRef<str>, remedy: &str) -> SceneError {
        let problem = format!("parameter {}: {}", shown(&self.name), problem.as_ref());
        SceneError::new(&self.place, problem, remedy)
    }

    /// The numbers, a multiple of `size` of them and at least one.
    pub(super) fn numbers(&self, size: usize) -> Result<&[f64], SceneError> {
        match &self.values {
            Values::Numbers(numbers) if !numbers.is_empty() && numbers.len().is_multiple_of(size) => Ok(numbers),
            Values::Numbers(numbers) => {
                Err(self
                    .error(format!("{} numbers are not a multiple of {size}", numbers.len()), "add what is missing"))
            }
            _ => Err(self.error("it has no numbers", "write numbers")),
        }
    }

    /// The only number.
    pub(super) fn number(&self) -> Result<f64, SceneError> {
        match self.numbers(1)? {
            [number] => Ok(*number),
            several => Err(self.error(format!("it has {} numbers", several.len()), "write a single one")),
        }
    }

    /// The only three numbers.
    pub(super) fn triple(&self) -> Result<[f64; 3], SceneError> {
        let numbers = self.numbers(1)?;
        let problem = || self.error(format!("it has {} numbers", numbers.len()), "write three");
        <[f64; 3]>::try_from(numbers).map_err(|_| problem())
    }

    /// The only string.
    pub(super) fn text(&self) -> Result<&str, SceneError> {
        match &self.values {
            Values::Texts(texts) if texts.len() == 1 => Ok(&texts[0]),
            _ => Err(self.error("it is not a single string", "write one string in quotes")),
        }
    }
}

/// The parameters of a directive.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    /// Where the directive stands.
    pub place: Location,
    list: Vec<Parameter>,
    /// The names of parameters that were asked for and not given.
    wanted: RefCell<BTreeSet<String>>,
}

/// A parameter that nobody asked for.
pub(super) struct Unused<'a> {
    pub parameter: &'a Parameter,
    /// Why, or which name was meant; may be empty.
    pub explanation: String,
}

impl Parameters {
    /// Reads all parameters that follow.
    pub(super) fn read(tokens: &mut Tokens<'_>, place: Location) -> Result<Self, SceneError> {
        let mut list = Vec::new();
        loop {
            let here = tokens.place(&place.path);
            let Some(declaration) = tokens.next_if_quoted()? else {
                return Ok(Self { place, list, wanted: RefCell::default() });
            };
            let words: Vec<&str> = declaration.split_whitespace().collect();
            let [kind, name] = words[..] else {
                let problem = format!("{} does not declare a parameter", shown(&declaration));
                return Err(SceneError::new(&here, problem, "write a type and a name, such as \"float radius\""));
            };
            if !NUMERIC.contains(&kind) && !OTHERS.contains(&kind) {
                let known: Vec<&str> = NUMERIC.iter().chain(&OTHERS).copied().collect();
                let problem = format!("there is no parameter type {}", shown(kind));
                return Err(SceneError::new(&here, problem, nearest_name(kind, &known)));
            }
            let values = values(tokens, kind, name, &here)?;
            let (kind, name) = (kind.to_owned(), name.to_owned());
            list.push(Parameter { kind, name, values, place: here, used: Cell::new(false) });
        }
    }

    /// The parameter of this name, if it was given: as in pbrt, the last one.
    pub(super) fn find(&self, name: &str) -> Option<&Parameter> {
        let found = self.list.iter().rev().find(|parameter| parameter.name == name);
        match found {
            Some(found) => found.used.set(true),
            None if self.list.is_empty() => {}
            None => drop(self.wanted.borrow_mut().insert(name.to_owned())),
        }
        found
    }

    /// Whether it was given.
    pub(super) fn has(&self, name: &str) -> bool {
        self.list.iter().any(|parameter| parameter.name == name)
    }

    /// Marks parameters that change nothing here.
    pub(super) fn pass_over(&self, names: &[&str]) {
        for name in names {
            self.find(name);
        }
    }

    /// Those that nobody asked for.
    pub(super) fn unused(&self) -> impl Iterator<Item = Unused<'_>> {
        let unused = self.list.iter().filter(|parameter| !parameter.used.get());
        unused.map(|parameter| Unused { parameter, explanation: self.explanation(&parameter.name) })
    }

    /// Why nobody asked for a parameter of this name, or which name was meant.
    fn explanation(&self, name: &str) -> String {
        if self.list.iter().any(|parameter| parameter.name == name && parameter.used.get()) {
            return "a later one of this name counts".to_owned();
        }
        let wanted = self.wanted.borrow();
        let meant = closest_name(name, wanted.iter().map(String::as_str));
        meant.map_or(String::new(), |meant| format!("did you mean \"{meant}\"?"))
    }

    /// A number.
    pub(super) fn float(&self, name: &str) -> Result<Option<f64>, SceneError> {
        self.find(name).map(Parameter::number).transpose()
    }

    /// A whole number.
    pub(super) fn integer(&self, name: &str) -> Result<Option<i64>, SceneError> {
        let Some(parameter) = self.find(name) else { return Ok(None) };
        let number = parameter.number()?;
        if number.fract() == 0.0 && number.abs() < 1e15 {
            return Ok(Some(number as i64));
        }
        Err(parameter.error(format!("{} is not a whole number", shown_number(number)), "write a whole number"))
    }

    /// True or false.
    pub(super) fn flag(&self, name: &str) -> Result<Option<bool>, SceneError> {
        let Some(parameter) = self.find(name) else { return Ok(None) };
        match &parameter.values {
            Values::Flags(flags) if flags.len() == 1 => Ok(Some(flags[0])),
            _ => Err(parameter.error("it is not a boolean", "write it as \"bool\", true or false")),
        }
    }

    /// A string.
    pub(super) fn text(&self, name: &str) -> Result<Option<&str>, SceneError> {
        self.find(name).map(Parameter::text).transpose()
    }

    /// A point or vector.
    pub(super) fn vector(&self, name: &str) -> Result<Option<DVec3>, SceneError> {
        Ok(self.find(name).map(Parameter::triple).transpose()?.map(DVec3::from_array))
    }

    /// Numbers in groups of `size`.
    pub(super) fn numbers(&self, name: &str, size: usize) -> Result<Option<&[f64]>, SceneError> {
        self.find(name).map(|parameter| parameter.numbers(size)).transpose()
    }
}

/// One value, or several in brackets.
fn values(tokens: &mut Tokens<'_>, kind: &str, name: &str, place: &Location) -> Result<Values, SceneError> {
    let refused = |problem: String, remedy: &str| {
        Err(SceneError::new(place, format!("parameter {}: {problem}", shown(name)), remedy))
    };
    let (mut numbers, mut texts, mut flags) = (Vec::new(), Vec::new(), Vec::new());
    let several = tokens.next_if_open();
    loop {
        match tokens.next()? {
            Some(Token::Close) if several => break,
            Some(Token::Word(word)) if NUMERIC.contains(&kind) => match word.parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                _ => return refused(format!("{} is not a finite number", shown(word)), "write a number such as 0.5"),
            },
            Some(Token::Word(word)) if kind == "bool" && (word == "true" || word == "false") => {
                flags.push(word == "true");
            }
            Some(Token::Quoted(text)) if kind == "bool" && (text == "true" || text == "false") => {
                flags.push(text == "true");
            }
            Some(Token::Quoted(text)) if matches!(kind, "string" | "texture" | "spectrum") => texts.push(text),
            Some(token) => return refused(format!("{} is no value of type {kind}", token.shown()), "check its type"),
            None => return refused("the file ends here".to_owned(), "add the value, or \"]\""),
        }
        if !several {
            break;
        }
    }
    if !numbers.is_empty() && !texts.is_empty() {
        return refused("it has numbers and strings".to_owned(), "write one or the other");
    }
    Ok(match kind {
        "bool" => Values::Flags(flags),
        "string" | "texture" => Values::Texts(texts),
        "spectrum" if !texts.is_empty() => Values::Texts(texts),
        _ => Values::Numbers(numbers),
    })
}
