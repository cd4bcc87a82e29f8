//! The forms that commands have: words in their order, those in capitals for what somebody names.

const FORMS: &str = include_str!("forms.txt");

/// All forms, one after the other.
pub(crate) fn all() -> impl Iterator<Item = &'static str> {
    FORMS.lines()
}

/// Whether somebody wants to read before anything is built.
pub(crate) fn ask_for_help(words: &[String]) -> bool {
    words.first().is_some_and(|first| first == "help") || words.iter().any(|word| word == "--help" || word == "-h")
}

/// What a command has instead of these words; none where it has them.
pub(crate) fn others(words: &[String]) -> Option<String> {
    let (command, options) = words.split_first()?;
    let mine: Vec<&str> = all().filter(|form| form.split(' ').next() == Some(command)).collect();
    if mine.iter().any(|form| is(form, words)) {
        return None;
    }
    let given = if options.is_empty() { "nothing behind it".to_owned() } else { format!("`{}`", options.join(" ")) };
    let lines: String = mine.iter().map(|form| format!("\n  cargo xtask {form}")).collect();
    Some(format!("`{command}` cannot be run with {given}: it must be one of{lines}"))
}

fn is(form: &str, words: &[String]) -> bool {
    let of_form: Vec<&str> = form.split(' ').collect();
    let fits = |(word, of_form): (&String, &&str)| word == of_form || of_form.starts_with(char::is_uppercase);
    words.len() == of_form.len() && words.iter().zip(&of_form).all(fits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_owned).collect()
    }

    fn others_of(text: &str) -> Option<String> {
        others(&words(text))
    }

    #[test]
    fn help_is_asked_for_anywhere() {
        let help = |text: &str| ask_for_help(&words(text));
        assert!(help("help") && help("--help") && help("calibrate --help") && help("fuzz campaign -h"));
        assert!(!help("calibrate --check") && !help("fuzz help 1"));
    }

    #[test]
    fn options_that_a_command_does_not_have_are_answered_by_those_that_it_has() {
        for known in ["ci", "reproduce-all --ensemble --check --all", "fuzz campaign 60", "semver HEAD~5"] {
            assert_eq!(others_of(known), None, "{known}");
        }
        let error = others_of("reproduce-all --ensemble --nonsense").expect("no such options");
        assert!(
            error.starts_with("`reproduce-all` cannot be run with `--ensemble --nonsense`: it must be one of\n"),
            "{error}"
        );
        assert!(error.contains("\n  cargo xtask reproduce-all --ensemble --page\n"), "{error}");
        assert!(!error.contains("calibrate"), "{error}");
        assert_eq!(
            others_of("semver").expect("no revision"),
            "`semver` cannot be run with nothing behind it: it must be one of\n  cargo xtask semver REVISION"
        );
        assert!(others_of("ci --write").is_some() && others_of("calibrate --all --check").is_some());
    }
}
