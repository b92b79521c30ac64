"""A reader of HTML that asks one thing: whether every tag that opens is closed, in order; <meta> alone need not be."""

from html.parser import HTMLParser


class _Balance(HTMLParser):
    """Keeps the open tags and those that ended out of turn."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong = [], []

    def handle_starttag(self, tag, attrs):
        if tag != "meta":
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass


def out_of_balance(page: str) -> tuple[list[str], list[str]]:
    """Tags that ended out of turn, and those that were never closed; both empty where all is well."""
    reader = _Balance()
    reader.feed(page)
    reader.close()
    return reader.wrong, reader.open
