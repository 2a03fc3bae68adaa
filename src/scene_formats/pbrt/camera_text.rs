//! Edits of the Camera directive in the text of a scene file.

use std::fmt::Write as _;
use std::sync::Arc;

use glam::{DAffine3, DMat4};

use super::SceneError;
use super::lexer::{Lexer, TokenKind};
use petzval_base::io::Location;

/// A value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraValue {
    /// A number.
    Number(f64),
    /// A pair of numbers.
    Pair([f64; 2]),
    /// A text, such as the name of a file.
    Text(String),
}

/// Edit of a Camera directive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CameraEdit {
    /// The place of the camera, if it changes: camera space to world space. It then stands still.
    pub world_from_camera: Option<DAffine3>,
    /// The parameters that change, by name.
    pub parameters: Vec<(&'static str, CameraValue)>,
}

impl CameraEdit {
    /// Applies the edit to the text of a scene file. `at` is the location of its Camera directive;
    /// `None` if there is none in this text. Everything else stays as it is.
    ///
    /// # Errors
    /// Returns an error if the text is not one of a scene.
    pub fn apply(&self, text: &[u8], at: &Location) -> Result<Option<Vec<u8>>, SceneError> {
        let mut lexer = Lexer::new(at.file.clone(), Arc::new(text.to_vec()));
        loop {
            let before = lexer.offset();
            let Some(token) = lexer.token()? else { return Ok(None) };
            if token.kind == TokenKind::Name("Camera".to_owned()) && lexer.location(&token) == *at {
                let blanks = lexer.offset() - before - "Camera".len();
                let mut edited = text[..before + blanks].to_vec();
                edited.extend(self.transform().bytes());
                edited.extend(b"Camera");
                self.directive(&mut lexer, text, &mut edited)?;
                return Ok(Some(edited));
            }
        }
    }

    /// Returns the directives that place the camera.
    fn transform(&self) -> String {
        let Some(world_from_camera) = self.world_from_camera else { return String::new() };
        let matrix = DMat4::from(world_from_camera.inverse()).to_cols_array();
        let numbers = matrix.map(|number| number.to_string()).join(" ");
        format!("ActiveTransform All\nTransform [ {numbers} ]\n")
    }

    /// Copies the directive with the parameters that stay, adds the others, and copies the rest of
    /// the file.
    fn directive(
        &self,
        lexer: &mut Lexer,
        text: &[u8],
        edited: &mut Vec<u8>,
    ) -> Result<(), SceneError> {
        let kind = lexer.offset();
        lexer.token()?;
        edited.extend(&text[kind..lexer.offset()]);
        loop {
            let from = lexer.offset();
            let mut ahead = lexer.clone();
            let Some(TokenKind::Text(declaration)) = ahead.token()?.map(|token| token.kind) else {
                break;
            };
            let mut token = ahead.token()?.map(|token| token.kind);
            if token == Some(TokenKind::Open) {
                while token.is_some_and(|kind| kind != TokenKind::Close) {
                    token = ahead.token()?.map(|token| token.kind);
                }
            }
            *lexer = ahead;
            let name = declaration.split_whitespace().last().unwrap_or_default();
            if !self.parameters.iter().any(|(changed, _)| *changed == name) {
                edited.extend(&text[from..lexer.offset()]);
            }
        }
        let mut added = String::new();
        for (name, value) in &self.parameters {
            let _ = match value {
                CameraValue::Number(number) => write!(added, "\n    \"float {name}\" [ {number} ]"),
                CameraValue::Pair([x, y]) => write!(added, "\n    \"point2 {name}\" [ {x} {y} ]"),
                CameraValue::Text(text) => {
                    let escaped = text.replace('\\', "\\\\").replace('"', "\\\"");
                    // Strings end with their line.
                    let escaped = escaped.replace('\n', "\\n").replace('\r', "\\r");
                    write!(added, "\n    \"string {name}\" [ \"{escaped}\" ]")
                }
            };
        }
        edited.extend(added.bytes());
        edited.extend(&text[lexer.offset()..]);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;

    fn edit(text: &str, line: u32, column: u32) -> Option<String> {
        let file: Arc<Path> = Path::new("a.pbrt").into();
        let edit = CameraEdit {
            world_from_camera: Some(DAffine3::from_translation([1.0, 2.0, -3.0].into())),
            parameters: vec![
                ("focusdistance", CameraValue::Number(0.25)),
                ("filmshift", CameraValue::Pair([1.5, -2.0])),
                ("lensfile", CameraValue::Text("a \"b\".dat\n".to_owned())),
            ],
        };
        let edited =
            edit.apply(text.as_bytes(), &Location { file, line, column }).expect("a scene");
        edited.map(|bytes| String::from_utf8(bytes).expect("UTF-8"))
    }

    #[test]
    fn only_the_camera_changes() {
        let text = "# Camera \"x\"\nFilm \"rgb\" # film\nScale 5 5 5 Camera \"realistic\" # lens\n  \
                    \"float focusdistance\" [ 4 ]  # m\n  \"float shutterclose\" 2\n  \
                    \"string lensfile\" \"c.dat\"\n\nWorldBegin # all\nShape \"sphere\"";
        let transform = "ActiveTransform All\nTransform [ 1 0 0 0 0 1 0 0 0 0 1 0 -1 -2 3 1 ]\n";
        let expected = format!(
            "# Camera \"x\"\nFilm \"rgb\" # film\nScale 5 5 5 {transform}Camera \"realistic\"  # m\n  \
             \"float shutterclose\" 2\n    \"float focusdistance\" [ 0.25 ]\n    \
             \"point2 filmshift\" [ 1.5 -2 ]\n    \"string lensfile\" [ \"a \\\"b\\\".dat\\n\" ]\n\n\
             WorldBegin # all\nShape \"sphere\""
        );
        assert_eq!(edit(text, 3, 13).as_deref(), Some(&expected[..]));
        assert_eq!(edit(text, 1, 3), None, "a comment is no camera");
    }
}
