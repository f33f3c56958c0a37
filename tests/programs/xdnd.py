# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""Drops files on a window like a file manager, with version 5 of the XDND protocol."""

import pathlib
import select
import time

from Xlib import X, display
from Xlib.protocol import event

TIMEOUT = 20  # seconds, for each answer of the window


def drop(display_name, window_id, paths):
    """Drops files. Raises RuntimeError if the window does not accept them."""
    connection = display.Display(display_name)
    try:
        _Source(connection, window_id, paths).run()
    finally:
        connection.close()


class _Source:
    def __init__(self, connection, window_id, paths):
        self.connection = connection
        self.target = connection.create_resource_object("window", window_id)
        self.window = connection.screen().root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)
        self.uris = "".join(pathlib.Path(path).absolute().as_uri() + "\r\n" for path in paths).encode()

    def atom(self, name):
        return self.connection.intern_atom(name)

    def send(self, kind, *data):
        data = (list(data) + [0] * 4)[:4]
        message = event.ClientMessage(
            window=self.target, client_type=self.atom(kind), data=(32, [self.window.id, *data])
        )
        self.target.send_event(message)
        self.connection.flush()

    def wait_for(self, condition):
        end = time.monotonic() + TIMEOUT
        while time.monotonic() < end:
            if not self.connection.pending_events():
                select.select([self.connection], [], [], 0.1)
                continue
            got = self.connection.next_event()
            if condition(got):
                return got
        raise RuntimeError("the window does not accept the files")

    def message(self, kind):
        return self.wait_for(lambda e: e.type == X.ClientMessage and e.client_type == self.atom(kind))

    def run(self):
        selection, uri_list = self.atom("XdndSelection"), self.atom("text/uri-list")
        self.window.set_selection_owner(selection, X.CurrentTime)
        self.send("XdndEnter", 5 << 24, uri_list)
        place = self.target.translate_coords(self.connection.screen().root, 0, 0)
        self.send("XdndPosition", 0, (10 - place.x) << 16 | (10 - place.y), X.CurrentTime, self.atom("XdndActionCopy"))
        if not self.message("XdndStatus").data[1][1] & 1:
            raise RuntimeError("the window rejects the files")
        self.send("XdndDrop", 0, X.CurrentTime)
        request = self.wait_for(lambda e: e.type == X.SelectionRequest and e.target == uri_list)
        request.requestor.change_property(request.property, uri_list, 8, self.uris)
        request.requestor.send_event(
            event.SelectionNotify(
                time=request.time,
                requestor=request.requestor,
                selection=selection,
                target=uri_list,
                property=request.property,
            )
        )
        self.connection.flush()
        self.message("XdndFinished")
