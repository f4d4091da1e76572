"""The bar: all views are within reach, however narrow the page is.

Feature: the page: token, rejected host names and origins, custom layouts, a menu on phones, reconnecting to a
    restarted server
"""

from __future__ import annotations

from browsing import Browser, Web

SHOWN = """(() => {
    const tab = document.querySelector('.tab[aria-current]').getBoundingClientRect();
    const bar = document.querySelector('#bar nav').getBoundingClientRect();
    return tab.left >= bar.left - 1 && tab.right <= bar.right + 1;
})()"""


def test_a_phone_has_a_menu_of_views(browser: Browser, web: Web) -> None:
    browser.resize(390, 844)
    browser.open(web.page("console"))
    browser.wait("document.querySelector('#bar .menu')?.value === 'console'")
    assert browser.run("return document.querySelector('#bar .menu').checkVisibility()")
    browser.choose("#bar .menu", "launches")
    browser.wait("document.querySelector('[data-panel=launches]')")
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")


def test_tabs_without_room_are_in_a_menu(browser: Browser, web: Web) -> None:
    browser.resize(1400, 900)
    browser.open(web.page("launches"))
    browser.wait("document.querySelector('[data-panel=launches]')")
    crowded = "document.querySelector('#bar').classList.contains('crowded')"
    browser.wait(f"!{crowded} && {SHOWN}")
    assert not browser.run("return document.querySelector('#bar .menu').checkVisibility()")
    browser.resize(700, 900)
    browser.wait(f"{crowded} && {SHOWN}")  # the tab of what is shown stays in sight
    assert browser.run("return document.querySelector('#bar .menu').checkVisibility()")
    fades = "['--left', '--right'].map((side) => document.querySelector('#bar nav').style.getPropertyValue(side))"
    assert browser.run(f"return {fades}") == ["24px", "0px"]
    browser.choose("#bar .menu", "graph")
    browser.wait(f"document.querySelector('[data-panel=graph]') && {SHOWN}")
    browser.wait(f"{fades}.join() === '0px,24px'")


def test_titles_name_keys_that_work(browser: Browser, web: Web) -> None:
    browser.open(web.page("graph"))
    titles = browser.wait("[...document.querySelectorAll('.tab')].map((tab) => tab.title)")
    assert [title.partition("(key ")[2] for title in titles[:10]] == [*(f"{key})" for key in range(1, 10)), ""]
    browser.run("document.body.dispatchEvent(new KeyboardEvent('keydown', {key: '9', bubbles: true}))")
    browser.wait("document.querySelector('.tab[aria-current]').title.includes('(key 9)')")


def test_a_layout_and_a_panel_of_one_name_are_told_apart(browser: Browser, web: Web) -> None:
    browser.open(web.page("graph"))
    browser.click("#bar button", "Layouts")
    browser.click(".layouts .title", "Bag")
    tabs = "[...document.querySelectorAll('.tab')].map((tab) => tab.textContent).filter((text) => text.includes('Bag'))"
    browser.wait(f"JSON.stringify({tabs}) === arguments[0]", '["▦ Bag","Bag"]')
    assert browser.run("return document.querySelector('.tab[aria-current]').textContent") == "▦ Bag"
