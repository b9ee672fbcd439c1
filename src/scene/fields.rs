//! Typed reading of one plugin's parameters. Every parameter that is asked for becomes a known name; whatever was
//! given and never asked for is an error with the nearest known name, as is a value of the wrong type.

use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::description::{Child, Node, PluginClass, Value};
use super::error::{Location, SceneError, nearest_name, shown_numbers};

/// Reads the parameters of one [`Node`]; call [`Fields::finish`] when all have been asked for.
pub struct Fields<'a> {
    node: &'a Node,
    known: Vec<&'static str>,
    used_parameters: Vec<bool>,
    used_children: Vec<bool>,
}

impl<'a> Fields<'a> {
    /// Starts reading `node`.
    pub fn new(node: &'a Node) -> Self {
        Self {
            node,
            known: Vec::new(),
            used_parameters: vec![false; node.parameters.len()],
            used_children: vec![false; node.children.len()],
        }
    }

    /// The node that is being read.
    pub fn node(&self) -> &'a Node {
        self.node
    }

    /// Where the node stands.
    pub fn location(&self) -> &'a Location {
        &self.node.location
    }

    /// Where parameter `name` stands, or the node itself when it was not given.
    pub fn location_of(&self, name: &str) -> &'a Location {
        let given = self.node.parameters.iter().find(|parameter| parameter.name == name);
        given.map_or(&self.node.location, |parameter| &parameter.location)
    }

    /// Whether the user gave parameter `name`.
    pub fn has(&self, name: &str) -> bool {
        self.node.parameters.iter().any(|parameter| parameter.name == name)
    }

    /// Whether the user gave parameter `name` as a color.
    pub fn is_rgb(&self, name: &str) -> bool {
        self.node.parameters.iter().any(|parameter| parameter.name == name && matches!(parameter.value, Value::Rgb(_)))
    }

    /// Whether the user gave parameter `name` as a vector or point.
    pub fn is_vector(&self, name: &str) -> bool {
        let vector = |value: &Value| matches!(value, Value::Vector(_));
        self.node.parameters.iter().any(|parameter| parameter.name == name && vector(&parameter.value))
    }

    /// An error about parameter `name`.
    pub fn error(&self, name: &str, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(self.location_of(name), problem, remedy)
    }

    fn know(&mut self, name: &'static str) {
        if !self.known.contains(&name) {
            self.known.push(name);
        }
    }

    fn take(&mut self, name: &'static str) -> Option<&'a Value> {
        self.know(name);
        let index = self.node.parameters.iter().position(|parameter| parameter.name == name)?;
        self.used_parameters[index] = true;
        Some(&self.node.parameters[index].value)
    }

    fn wrong_type(&self, name: &str, value: &Value, wanted: &str) -> SceneError {
        let problem = format!("parameter \"{name}\" is a {} where a {wanted} belongs", value.type_name());
        self.error(name, problem, format!("write it as {wanted}"))
    }

    /// A finite number; integers are accepted.
    pub fn float(&mut self, name: &'static str) -> Result<Option<f64>, SceneError> {
        let number = match self.take(name) {
            None => return Ok(None),
            Some(Value::Float(number)) => *number,
            Some(Value::Integer(number)) => *number as f64,
            Some(other) => return Err(self.wrong_type(name, other, "float")),
        };
        if !number.is_finite() {
            return Err(self.error(name, format!("\"{name}\" is {number}"), "give a finite number"));
        }
        Ok(Some(number))
    }

    /// An integer.
    pub fn integer(&mut self, name: &'static str) -> Result<Option<i64>, SceneError> {
        match self.take(name) {
            None => Ok(None),
            Some(Value::Integer(number)) => Ok(Some(*number)),
            Some(other) => Err(self.wrong_type(name, other, "integer")),
        }
    }

    /// A truth value.
    pub fn boolean(&mut self, name: &'static str) -> Result<Option<bool>, SceneError> {
        match self.take(name) {
            None => Ok(None),
            Some(Value::Boolean(flag)) => Ok(Some(*flag)),
            Some(other) => Err(self.wrong_type(name, other, "boolean")),
        }
    }

    /// A string.
    pub fn string(&mut self, name: &'static str) -> Result<Option<&'a str>, SceneError> {
        match self.take(name) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => Err(self.wrong_type(name, other, "string")),
        }
    }

    /// A colour: three finite, non-negative numbers; a single number means grey.
    pub fn rgb(&mut self, name: &'static str) -> Result<Option<[f64; 3]>, SceneError> {
        let rgb = match self.take(name) {
            None => return Ok(None),
            Some(Value::Rgb(rgb)) => *rgb,
            Some(Value::Float(grey)) => [*grey; 3],
            Some(Value::Integer(grey)) => [*grey as f64; 3],
            Some(other) => return Err(self.wrong_type(name, other, "rgb")),
        };
        if rgb.iter().any(|channel| !channel.is_finite() || *channel < 0.0) {
            let problem = format!("\"{name}\" is {}", shown_numbers(rgb));
            return Err(self.error(name, problem, "give three finite numbers of at least 0"));
        }
        Ok(Some(rgb))
    }

    /// A point or vector of three finite numbers.
    pub fn vector(&mut self, name: &'static str) -> Result<Option<DVec3>, SceneError> {
        let vector = match self.take(name) {
            None => return Ok(None),
            Some(Value::Vector(vector)) => DVec3::from_array(*vector),
            Some(other) => return Err(self.wrong_type(name, other, "point or vector")),
        };
        if !vector.is_finite() {
            return Err(self.error(name, format!("\"{name}\" is not finite"), "give three finite numbers"));
        }
        Ok(Some(vector))
    }

    /// A transform of finite numbers with an inverse; identity when it was not given.
    pub fn transform(&mut self, name: &'static str) -> Result<DMat4, SceneError> {
        let matrix = match self.take(name) {
            None => return Ok(DMat4::IDENTITY),
            Some(Value::Transform(matrix)) => *matrix,
            Some(other) => return Err(self.wrong_type(name, other, "transform")),
        };
        if !matrix.is_finite() || matrix.determinant() == 0.0 || !matrix.inverse().is_finite() {
            let problem = format!("\"{name}\" flattens space to zero volume or is not finite");
            return Err(self.error(name, problem, "give a transform that can be inverted"));
        }
        Ok(matrix)
    }

    /// The first not yet read child of a class, whatever its slot is called.
    pub fn child(&mut self, class: PluginClass) -> Option<&'a Arc<Node>> {
        let index = (0..self.node.children.len())
            .find(|&index| !self.used_children[index] && self.node.children[index].node.class == class)?;
        self.used_children[index] = true;
        Some(&self.node.children[index].node)
    }

    /// The child of a class in slot `name`.
    pub fn named_child(&mut self, class: PluginClass, name: &'static str) -> Option<&'a Arc<Node>> {
        self.know(name);
        let index = self.node.children.iter().position(|child| child.name == name && child.node.class == class)?;
        self.used_children[index] = true;
        Some(&self.node.children[index].node)
    }

    /// All children of a class, in order.
    pub fn children(&mut self, class: PluginClass) -> Vec<&'a Arc<Node>> {
        let mut found = Vec::new();
        for (child, used) in self.node.children.iter().zip(&mut self.used_children) {
            if child.node.class == class && !std::mem::replace(used, true) {
                found.push(&child.node);
            }
        }
        found
    }

    /// Marks parameters that Mitsuba knows and that change nothing here, so that they are not an error.
    pub fn ignore(&mut self, names: &[&'static str]) {
        for name in names {
            self.take(name);
        }
    }

    /// Fails on the first parameter or child that nobody asked for.
    pub fn finish(self) -> Result<(), SceneError> {
        let class = self.node.class.tag();
        let plugin = &self.node.plugin;
        if let Some(index) = self.used_parameters.iter().position(|used| !used) {
            let parameter = &self.node.parameters[index];
            let twice = self.known.contains(&parameter.name.as_str());
            let problem = if twice {
                format!("parameter \"{}\" of {class} \"{plugin}\" is given twice", parameter.name)
            } else {
                format!("{class} \"{plugin}\" has no parameter \"{}\"", parameter.name)
            };
            let remedy = if twice { "give it once".to_owned() } else { nearest_name(&parameter.name, &self.known) };
            return Err(SceneError::new(&parameter.location, problem, remedy));
        }
        match self.used_children.iter().position(|used| !used) {
            Some(index) => Err(self.unwanted(&self.node.children[index])),
            None => Ok(()),
        }
    }

    /// The error about a child that nobody asked for.
    fn unwanted(&self, child: &Child) -> SceneError {
        let (class, plugin, name) = (self.node.class.tag(), &self.node.plugin, child.name.as_str());
        let location = &child.node.location;
        let slots = child.node.class == PluginClass::Texture && class != PluginClass::Scene.tag();
        if slots && !self.known.contains(&name) {
            let problem = match name {
                "" => format!("a texture of {class} \"{plugin}\" has no name"),
                name => format!("{class} \"{plugin}\" has no parameter \"{name}\""),
            };
            return SceneError::new(location, problem, nearest_name(name, &self.known));
        }
        let given =
            (self.node.children.iter().zip(&self.used_children)).any(|(other, used)| *used && other.name == name);
        if slots && !given {
            let problem = format!("parameter \"{name}\" of {class} \"{plugin}\" cannot be a texture");
            return SceneError::new(location, problem, "give a plain value");
        }
        let problem = format!("{class} \"{plugin}\" cannot hold another {}", child.node.class.tag());
        SceneError::new(location, problem, "remove it or move it to where it belongs")
    }
}
