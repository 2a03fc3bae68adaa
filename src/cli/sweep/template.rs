//! File names with placeholders in braces.

/// A name such as `out/{lens}_{fstop}.exr`; `{{` and `}}` are braces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Template(Vec<Piece>);

#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Text(String),
    Placeholder(String),
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
                    "{text}: an unmatched brace; expected {{NAME}}, or {{{{ for a brace"
                ));
            };
            pieces.push(Piece::Text(std::mem::take(&mut plain)));
            pieces.push(Piece::Placeholder(name.to_owned()));
            left = rest;
        }
        plain.push_str(left);
        pieces.push(Piece::Text(plain));
        Ok(Self(pieces))
    }

    /// Returns the names of the placeholders.
    pub fn placeholders(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter_map(|piece| match piece {
            Piece::Placeholder(name) => Some(name.as_str()),
            Piece::Text(_) => None,
        })
    }

    /// Returns the text before the first placeholder.
    pub fn prefix(&self) -> &str {
        match self.0.first() {
            Some(Piece::Text(text)) => text,
            _ => "",
        }
    }

    /// Returns the name with values in place of the placeholders; slashes in values become dashes.
    pub fn filled<'a>(&self, value: impl Fn(&str) -> &'a str) -> String {
        let filled = self.0.iter().map(|piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Placeholder(name) => value(name).replace(['/', '\\'], "-"),
        });
        filled.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placeholders_are_filled_and_braces_kept() {
        let template = Template::parse("out/{lens}_{{{fstop}}}.exr").unwrap();
        assert_eq!(template.placeholders().collect::<Vec<_>>(), ["lens", "fstop"]);
        assert_eq!(template.prefix(), "out/");
        assert_eq!(
            template.filled(|name| if name == "lens" { "a/b" } else { "2" }),
            "out/a-b_{2}.exr"
        );
        assert_eq!(Template::parse("a.exr").unwrap().filled(|_| ""), "a.exr");
    }

    #[test]
    fn an_unmatched_brace_is_refused() {
        for text in ["{", "a}", "{a", "{a{b}", "}}}", "{{{"] {
            assert!(Template::parse(text).is_err(), "{text}");
        }
    }
}
