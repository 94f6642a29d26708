"""The page and the documentation come from here alone."""

import re

import httpx
import pytest


def test_the_page_allows_nothing_from_elsewhere(client: httpx.Client) -> None:
    response = client.get("/")
    assert response.headers["content-type"].startswith("text/html")
    policy = response.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert client.head("/").status_code == 200


@pytest.mark.parametrize("path", ["/", "/docs"])
def test_everything_that_is_linked_is_served_here(client: httpx.Client, path: str) -> None:
    links = re.findall(r'(?:src|href)="([^"]+)"', client.get(path).text)
    assert links
    for link in links:
        response = client.get(link)
        assert response.status_code == 200, link
        assert response.url.host == client.base_url.host
