"""MenuHandler: menus of interactive markers, with a callback for each entry."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rospy

from pyros1.msgs.visualization_msgs.msg import InteractiveMarkerFeedback, MenuEntry


class EntryContext:
    """An entry of a menu, with its sub-entries."""

    def __init__(self) -> None:
        self.title = ""
        self.command = ""
        self.command_type = 0
        self.sub_entries: list[int] = []
        self.visible = True
        self.check_state = 0
        self.feedback_cb: Callable[[Any], object] | None = None


class MenuHandler:
    """A menu, which can be attached to several markers. Entries are identified by handles: numbers from 1."""

    NO_CHECKBOX = 0
    CHECKED = 1
    UNCHECKED = 2

    def __init__(self) -> None:
        self.top_level_handles_: list[int] = []
        self.entry_contexts_: dict[int, EntryContext] = {}
        self.current_handle_ = 1
        self.managed_markers_: set[str] = set()

    def insert(
        self,
        title: str,
        parent: int | None = None,
        command_type: int = MenuEntry.FEEDBACK,
        command: str = "",
        callback: Callable[[Any], object] | None = None,
    ) -> int | None:
        """Add an entry.

        Args:
            title: the text of the entry.
            parent: handle of the parent entry; None for an entry at the top level.
            command_type, command: what RViz does; see visualization_msgs/MenuEntry.
            callback: called with the feedback when the entry is selected.

        Returns:
            The entry's handle; None if there is no such parent.
        """
        handle = self.doInsert(title, command_type, command, callback)
        if parent is None:
            self.top_level_handles_.append(handle)
        elif parent in self.entry_contexts_:
            self.entry_contexts_[parent].sub_entries.append(handle)
        else:
            rospy.logerr("Parent menu entry " + str(parent) + " not found.")
            return None
        return handle

    def setVisible(self, handle: int, visible: bool) -> bool:
        """Show or hide an entry; takes effect at the next `reApply`. Return whether the entry exists."""
        context = self.entry_contexts_.get(handle)
        if context is not None:
            context.visible = visible
        return context is not None

    def setCheckState(self, handle: int, check_state: int) -> bool:
        """Set whether an entry has a checkbox and is checked, from the next `reApply` on; return whether it exists."""
        context = self.entry_contexts_.get(handle)
        if context is not None:
            context.check_state = check_state
        return context is not None

    def getCheckState(self, handle: int) -> int | None:
        """Return the value set by `setCheckState`; None if there is no such entry."""
        context = self.entry_contexts_.get(handle)
        return None if context is None else context.check_state

    def getTitle(self, handle: int) -> str | None:
        """Return the text of an entry; None if there is no such entry."""
        context = self.entry_contexts_.get(handle)
        return None if context is None else context.title

    def apply(self, server: Any, marker_name: str) -> bool:
        """Attach the menu to a marker of an InteractiveMarkerServer, whose `applyChanges` must be called afterwards.

        Returns:
            Whether there is such a marker.
        """
        marker = server.get(marker_name)
        if marker is None:
            self.managed_markers_.discard(marker_name)
            return False
        marker.menu_entries = []
        self.pushMenuEntries(self.top_level_handles_, marker.menu_entries, 0)
        server.insert(marker, self.processFeedback, InteractiveMarkerFeedback.MENU_SELECT)
        self.managed_markers_.add(marker_name)
        return True

    def pushMenuEntries(self, handles_in: list[int], entries_out: list[Any], parent_handle: int) -> bool:
        """Append entries, and the entries below them, as visualization_msgs/MenuEntry; hidden ones are skipped.

        Args:
            handles_in: the handles.
            entries_out: what to append to.
            parent_handle: handle of the entry above; 0 for none.

        Returns:
            Whether all entries exist; appending stops at the first one that does not.
        """
        for handle in handles_in:
            context = self.entry_contexts_.get(handle)
            if context is None:
                rospy.logerr(f"There is no menu entry {handle}.")
                return False
            if context.visible:
                entries_out.append(self.makeEntry(context, handle, parent_handle))
                if not self.pushMenuEntries(context.sub_entries, entries_out, handle):
                    return False
        return True

    def reApply(self, server: Any) -> bool:
        """Update the menu on all markers that have it; return False if one of them no longer exists."""
        applied = [self.apply(server, name) for name in list(self.managed_markers_)]  # apply() removes missing ones
        return all(applied)

    def doInsert(self, title: str, command_type: int, command: str, feedback_cb: Callable[[Any], object] | None) -> int:
        """Create an entry that is in no menu yet; return its handle."""
        handle = self.current_handle_
        self.current_handle_ += 1
        context = self.entry_contexts_[handle] = EntryContext()
        context.title, context.command, context.command_type = title, command, command_type
        context.feedback_cb = feedback_cb
        return handle

    def processFeedback(self, feedback: Any) -> None:
        """Call the callback of the selected entry."""
        context = self.entry_contexts_.get(feedback.menu_entry_id)
        if context is not None and context.feedback_cb is not None:
            context.feedback_cb(feedback)

    def makeEntry(self, context: EntryContext, handle: int, parent_handle: int) -> Any:
        """Return an entry as visualization_msgs/MenuEntry."""
        checkbox = {self.CHECKED: "[x] ", self.UNCHECKED: "[ ] "}.get(context.check_state, "")
        return MenuEntry(
            id=handle,
            parent_id=parent_handle,
            title=checkbox + context.title,
            command=context.command,
            command_type=context.command_type,
        )
