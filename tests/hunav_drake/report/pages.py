"""What is seen of the page of a report."""

from html import unescape
import re


def visible(html):
    """Returns the text of a page without tags, styles and pictures."""
    html = re.sub(r"<(style|svg).*?</\1>", "", html, flags=re.DOTALL)
    html = html.replace("<wbr>", "")
    return " ".join(unescape(re.sub(r"<[^>]*>", " ", html)).split())
