"""A reader of HTML that asks one thing: whether every tag that opens is closed, in order."""

from html.parser import HTMLParser

_VOID = {"meta", "br", "hr", "img", "link", "input"}


class _Balance(HTMLParser):
    """Keeps the open tags and those that ended out of turn."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong = [], []

    def handle_starttag(self, tag, attrs):
        if tag not in _VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass


def are_balanced(page: str) -> bool:
    """Whether a page's tags are."""
    reader = _Balance()
    reader.feed(page)
    reader.close()
    return not reader.wrong and not reader.open
