//! Descriptions as text, to compare what two files mean.

use std::collections::HashMap;
use std::fmt::Write as _;

use photonfarm::scene::description::{Node, SceneDescription};

/// The tree without places and ids: every number with all its bits, and shared plugins once, by their order.
pub(crate) fn tree(description: &SceneDescription) -> String {
    let mut text = String::new();
    write_node(&description.root, 0, &mut HashMap::new(), &mut text);
    text
}

fn write_node(node: &Node, depth: usize, known: &mut HashMap<*const Node, usize>, text: &mut String) {
    let indent = "  ".repeat(depth);
    writeln!(text, "{indent}{} {}", node.class.tag(), node.plugin).unwrap();
    let mut parameters: Vec<String> =
        node.parameters.iter().map(|parameter| format!("{} = {:?}", parameter.name, parameter.value)).collect();
    parameters.sort();
    for parameter in parameters {
        writeln!(text, "{indent}  {parameter}").unwrap();
    }
    for child in &node.children {
        let count = known.len();
        let number = *known.entry(std::sync::Arc::as_ptr(&child.node)).or_insert(count);
        writeln!(text, "{indent}  \"{}\" #{number}", child.name).unwrap();
        if number == count {
            write_node(&child.node, depth + 2, known, text);
        }
    }
}
