//! Text with code in it, as Markdown writes it: between backticks.

use maud::{Markup, html};

/// The text with what stands between backticks as code; a backtick without a partner stays.
pub(super) fn inline(text: &str) -> Markup {
    let parts: Vec<&str> = text.split('`').collect();
    let last = parts.len() - 1;
    html! {
        @for (i, part) in parts.iter().enumerate() {
            @if i % 2 == 0 { (part) }
            @else if i < last { code { (part) } }
            @else { "`" (part) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::inline;

    #[test]
    fn code_is_between_backticks() {
        let html = |text: &str| inline(text).into_string();
        assert_eq!(
            html("`y` of <b> is `2 V`."),
            "<code>y</code> of &lt;b&gt; is <code>2 V</code>."
        );
        assert_eq!(html("plain"), "plain");
        assert_eq!(html("a `b"), "a `b");
        assert_eq!(html("`a` and `b"), "<code>a</code> and `b");
    }
}
