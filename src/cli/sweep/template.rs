//! Names with places in braces, to be filled.

/// A name such as `out/{lens}_{fstop}.exr`; `{{` and `}}` are braces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Template(Vec<Piece>);

#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Text(String),
    Place(String),
}

impl Template {
    pub fn parse(text: &str) -> Result<Self, String> {
        let (mut pieces, mut plain) = (Vec::new(), String::new());
        let mut left = text;
        while let Some(brace) = left.find(['{', '}']) {
            plain.push_str(&left[..brace]);
            let behind = &left[brace + 1..];
            let kind = &left[brace..brace + 1];
            if let Some(rest) = behind.strip_prefix(kind) {
                plain.push_str(kind);
                left = rest;
                continue;
            }
            let place =
                behind.split_once('}').filter(|(name, _)| kind == "{" && !name.contains('{'));
            let Some((name, rest)) = place else {
                return Err(format!(
                    "{text}: a brace without its other; expected {{NAME}}, or {{{{ for a brace"
                ));
            };
            pieces.push(Piece::Text(std::mem::take(&mut plain)));
            pieces.push(Piece::Place(name.to_owned()));
            left = rest;
        }
        plain.push_str(left);
        pieces.push(Piece::Text(plain));
        Ok(Self(pieces))
    }

    /// The names of its places.
    pub fn places(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter_map(|piece| match piece {
            Piece::Place(name) => Some(name.as_str()),
            Piece::Text(_) => None,
        })
    }

    /// What is in front of the first place.
    pub fn front(&self) -> &str {
        match self.0.first() {
            Some(Piece::Text(text)) => text,
            _ => "",
        }
    }

    /// With what stands at each place; in a value a slash is no folder.
    pub fn filled<'a>(&self, value: impl Fn(&str) -> &'a str) -> String {
        let filled = self.0.iter().map(|piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Place(name) => value(name).replace(['/', '\\'], "-"),
        });
        filled.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_filled_and_braces_kept() {
        let template = Template::parse("out/{lens}_{{{fstop}}}.exr").unwrap();
        assert_eq!(template.places().collect::<Vec<_>>(), ["lens", "fstop"]);
        assert_eq!(template.front(), "out/");
        assert_eq!(
            template.filled(|name| if name == "lens" { "a/b" } else { "2" }),
            "out/a-b_{2}.exr"
        );
        assert_eq!(Template::parse("a.exr").unwrap().filled(|_| ""), "a.exr");
    }

    #[test]
    fn a_lone_brace_is_refused() {
        for text in ["{", "a}", "{a", "{a{b}", "}}}", "{{{"] {
            assert!(Template::parse(text).is_err(), "{text}");
        }
    }
}
