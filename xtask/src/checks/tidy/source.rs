//! Rust source as words: comments, texts and test modules left out.

/// A word of a source: a name, or one sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Name(String),
    Sign(char),
}

impl Word {
    pub(super) fn is_name(&self, name: &str) -> bool {
        matches!(self, Self::Name(found) if found == name)
    }
}

/// The words of a source, without what only its tests need.
pub(super) fn words(source: &str) -> Vec<Word> {
    let mut words = split(source);
    if let Some(tests) = position_of_tests(&words) {
        words.truncate(tests);
    }
    words
}

/// Where `#[cfg(test)] mod tests` begins, or `#[cfg(all(test, ...))] mod tests`: tests stand last in a file.
fn position_of_tests(words: &[Word]) -> Option<usize> {
    let name = |name: &str| Word::Name(name.to_owned());
    let head = ['#', '['].map(Word::Sign).into_iter().chain([name("cfg"), Word::Sign('(')]);
    let head: Vec<Word> = head.collect();
    let only_in_tests = [vec![name("test")], vec![name("all"), Word::Sign('('), name("test")]];
    let begins = |at: &usize| {
        let condition = words[*at..].strip_prefix(head.as_slice());
        condition.is_some_and(|condition| only_in_tests.iter().any(|only| condition.starts_with(only)))
    };
    let module = |at: &usize| {
        let end = words[*at..].iter().position(|word| *word == Word::Sign(']')).map_or(words.len(), |end| at + end);
        words.get(end + 1).is_some_and(|word| word.is_name("mod")).then_some(end + 1)
    };
    let (at, module) = (0..words.len()).filter(begins).find_map(|at| Some((at, module(&at)?)))?;
    // `mod tests;` is a file of its own, and what follows it counts.
    (*words.get(module + 2)? == Word::Sign('{')).then_some(at)
}

fn split(source: &str) -> Vec<Word> {
    let mut words = Vec::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(length) = text_length(rest) {
            length
        } else if first.is_alphabetic() || first == '_' {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
            words.push(Word::Name(rest[..end].to_owned()));
            end
        } else {
            if !first.is_whitespace() {
                words.push(Word::Sign(first));
            }
            first.len_utf8()
        };
        rest = &rest[length..];
    }
    words
}

/// How long the text or character is that begins here, if one does.
fn text_length(rest: &str) -> Option<usize> {
    if let Some(raw) = rest.strip_prefix('r').filter(|raw| raw.starts_with(['"', '#'])) {
        let hashes = raw.chars().take_while(|c| *c == '#').count();
        let body = raw[hashes..].strip_prefix('"')?;
        let end = format!("\"{}", "#".repeat(hashes));
        return Some(1 + hashes + 1 + body.find(&end).map_or(body.len(), |at| at + end.len()));
    }
    if rest.starts_with('"') {
        return Some(quoted_length(rest, '"'));
    }
    // 'a' and '\n' are characters, 'a without a second quote is a lifetime.
    let body = rest.strip_prefix('\'')?;
    let is_character = body.starts_with('\\') || body.chars().nth(1) == Some('\'');
    is_character.then(|| quoted_length(rest, '\''))
}

fn quoted_length(rest: &str, quote: char) -> usize {
    let mut is_escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            c if c == quote => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(source: &str) -> String {
        let word = |word: &Word| match word {
            Word::Name(name) => name.clone(),
            Word::Sign(sign) => sign.to_string(),
        };
        words(source).iter().map(word).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn comments_texts_and_tests_are_left_out() {
        assert_eq!(text("use a; // use b;\n/* use c; */ x"), "use a ; x");
        assert_eq!(text("f(\"use \\\" b\", 'c', '\\'', r#\"a \" b\"#)"), "f ( , , , )");
        assert_eq!(text("fn f<'a>(x: &'a str) {}"), "fn f < ' a > ( x : & ' a str ) { }");
        assert_eq!(text("a\n#[cfg(test)]\nmod tests {\n use b;\n}\n"), "a");
        assert_eq!(text("a\n#[cfg(all(test, feature = \"c\"))]\nmod tests {\n use b;\n}\n"), "a");
        assert_eq!(text("#[cfg(test)] fn f() {}"), "# [ cfg ( test ) ] fn f ( ) { }");
        assert_eq!(text("#[cfg(test)]\nmod tests;\nb"), "# [ cfg ( test ) ] mod tests ; b");
    }
}
