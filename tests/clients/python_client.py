#!/usr/bin/env python3
"""A client written from docs/protocol.md alone, on libraries that share no code with the server.

usage: python_client.py PORT SCENE CAMERAS.json ANSWERS.json GENERATED

Holds a whole conversation on python3-websockets, with the code that flatc makes of the schema in
GENERATED. CAMERAS.json are eye and target cameras; ANSWERS.json is what `culld cull --method
frustum` says about them. Ends with 0 if everything came as the document says.
"""

import asyncio
import json
import struct
import sys
import urllib.request

import flatbuffers
import websockets

sys.path.insert(0, sys.argv[5])
from culld.fbs.Body import Body  # noqa: E402
from culld.fbs.Camera import CameraT  # noqa: E402
from culld.fbs.CameraUpdate import CameraUpdateT  # noqa: E402
from culld.fbs.Cancel import CancelT  # noqa: E402
from culld.fbs.CloseView import CloseViewT  # noqa: E402
from culld.fbs.Demand import DemandT  # noqa: E402
from culld.fbs.Edit import EditT  # noqa: E402
from culld.fbs.EditItem import EditItemT  # noqa: E402
from culld.fbs.EditKind import EditKind  # noqa: E402
from culld.fbs.Encoding import Encoding  # noqa: E402
from culld.fbs.Feature import Feature  # noqa: E402
from culld.fbs.Hello import HelloT  # noqa: E402
from culld.fbs.LookAt import LookAtT  # noqa: E402
from culld.fbs.Message import Message, MessageT  # noqa: E402
from culld.fbs.OpenView import OpenViewT  # noqa: E402
from culld.fbs.Ping import PingT  # noqa: E402
from culld.fbs.Vec3 import Vec3T  # noqa: E402
from culld.fbs.WireCode import WireCode  # noqa: E402

PATIENCE_S = 60


def expect(holds, what):
    if not holds:
        raise AssertionError(what)


# --- sets of ids (docs/protocol.md "Sets of ids") --------------------------------------------------


def varint(data, at):
    value = 0
    for i in range(5):
        byte = data[at + i]
        value |= (byte & 0x7F) << (7 * i)
        if byte < 0x80:
            return value, at + i + 1
    raise ValueError("a varint of more than five bytes")


def gap_list(data, at, count=None):
    ids = []
    while len(ids) < count if count is not None else at < len(data):
        gap, at = varint(data, at)
        ids.append(gap if not ids else ids[-1] + 1 + gap)
    return ids, at


def two_level_bitset(data):
    count, at = varint(data, 0)
    masks = struct.unpack_from(f"<{count}Q", data, at)
    at += 8 * count
    ids = []
    for m, mask in enumerate(masks):
        for w in range(64):
            if mask >> w & 1:
                (word,) = struct.unpack_from("<Q", data, at)
                at += 8
                ids += [(64 * m + w) * 64 + bit for bit in range(64) if word >> bit & 1]
    return ids, at


def decode_set(answer, baseline):
    data = bytes(answer.payload) if answer.payload is not None else b""
    end = len(data)
    if answer.encoding == Encoding.RawU32:
        ids = list(struct.unpack(f"<{len(data) // 4}I", data))
    elif answer.encoding == Encoding.DeltaVarint:
        ids, end = gap_list(data, 0)
    elif answer.encoding == Encoding.TwoLevelBitset:
        ids, end = two_level_bitset(data)
    else:
        count, at = varint(data, 0)
        added, at = gap_list(data, at, count)
        count, at = varint(data, at)
        removed, end = gap_list(data, at, count)
        expect(not set(added) & baseline and set(removed) <= baseline, "a change of another set")
        ids = sorted((baseline - set(removed)) | set(added))
    expect(end == len(data), "bytes left over")
    expect(all(a < b for a, b in zip(ids, ids[1:])), "ids out of order")
    expect(not ids or ids[-1] < answer.sceneObjects, "an id past the last")
    return set(ids)


def mix(x):
    x ^= x >> 16
    x = x * 0x85EBCA6B & 0xFFFFFFFF
    x ^= x >> 13
    x = x * 0xC2B2AE35 & 0xFFFFFFFF
    return x ^ x >> 16


def set_hash(ids):
    high = sum(mix(i ^ 0x9E3779B9) for i in ids) & 0xFFFFFFFF
    low = sum(mix(i + 1) for i in ids) & 0xFFFFFFFF
    return high << 32 | low


# --- messages --------------------------------------------------------------------------------------


def make(table_type, **fields):
    table = table_type()
    for name, value in fields.items():
        expect(hasattr(table, name), f"{table_type.__name__} has no {name}")
        setattr(table, name, value)
    return table


def vec3(xyz):
    return make(Vec3T, x=xyz[0], y=xyz[1], z=xyz[2])


def camera_of(entry):
    look = make(LookAtT, eye=vec3(entry["eye"]), target=vec3(entry["target"]),
                up=vec3(entry.get("up", [0, 1, 0])), yfovRad=entry["yfov"], aspect=entry["aspect"],
                znearM=entry["znear"], zfarM=entry.get("zfar") or 0.0)
    return make(CameraT, lookAt=look, widthPx=1280, heightPx=720)


class Client:
    def __init__(self, socket):
        self.socket = socket
        self.last_id = 0
        self.frames = {}  # view -> {frame: set}
        self.deltas = 0
        self.notices = []

    async def send(self, table):
        self.last_id += 1
        body_type = getattr(Body, type(table).__name__[:-1])
        message = make(MessageT, id=self.last_id, bodyType=body_type, body=table)
        builder = flatbuffers.Builder(256)
        builder.Finish(message.Pack(builder), b"CLD1")
        await self.socket.send(bytes(builder.Output()))
        return self.last_id

    async def receive(self):
        """(id, name of the body, body); what comes unasked is kept in `notices`."""
        while True:
            data = await asyncio.wait_for(self.socket.recv(), PATIENCE_S)
            expect(isinstance(data, bytes) and data[4:8] == b"CLD1", "not a binary CLD1 message")
            message = MessageT.InitFromObj(Message.GetRootAs(data, 0))
            names = {v: k for k, v in vars(Body).items() if not k.startswith("_")}
            name = names[message.bodyType]
            if name not in ("SceneChanged", "GoAway"):
                return message.id, name, message.body
            expect(message.id == 0, f"{name} has an id")
            self.notices.append((name, message.body))

    async def ask(self, table, reply):
        asked = await self.send(table)
        got, name, body = await self.receive()
        expect((got, name) == (asked, reply), f"{name} for {got} instead of {reply} for {asked}")
        return body

    async def refused(self, table, code):
        error = await self.ask(table, "ErrorReply")
        expect(error.code == code, f"code {error.code} instead of {code}: {error.message}")
        expect(b"\n" not in error.message, "an error of several lines")

    def take(self, answer):
        frames = self.frames.setdefault(answer.view, {})
        baseline = frames[answer.baseline] if answer.baseline else set()
        self.deltas += answer.baseline != 0
        ids = decode_set(answer, baseline)
        expect(len(ids) == answer.objectCount, "object_count is of another set")
        expect(set_hash(ids) == answer.setHash, "set_hash is of another set")
        frames[answer.frame] = ids
        return ids

    def update(self, view, camera, ack=0, **fields):
        return make(CameraUpdateT, view=view, camera=camera, ackFrame=ack, **fields)


async def connect(port, scene):
    socket = await websockets.connect(f"ws://127.0.0.1:{port}/v1/scenes/{scene}/live",
                                      subprotocols=["culld.v1"], max_size=64 << 20,
                                      compression=None)
    expect(socket.subprotocol == "culld.v1", "another subprotocol")
    return Client(socket)


async def greet(client, scene):
    features = Feature.Cancel | Feature.Deadlines
    hello = make(HelloT, protoMin=1, protoMax=1, client="python", features=features)
    welcome = await client.ask(hello, "Welcome")
    expect(welcome.protocol == 1 and welcome.scene.name == scene.encode(), "another scene")
    expect(welcome.features & features == features, "a feature is missing")
    limits = welcome.moreLimits
    expect(welcome.limits.maxViews == 64 and limits.maxRequestsInFlight == 192 and
           limits.maxTextBytes == 4096, "limits are not those of the document")
    return welcome


async def follow_cameras(client, cameras, truth, nodes):
    """Every set, whole or as a change, is what the engine says in process."""
    ack = 0
    for number, entry in enumerate(cameras):
        update = client.update(1, camera_of(entry), ack)
        answer = await client.ask(update, "Answer")
        ids = client.take(answer)
        expect(sorted({nodes[i] for i in ids}) == truth[number], f"camera {number}: another set")
        expect(answer.method == b"frustum" and answer.proven, "another method, or no proof")
        expect(answer.seenCount + answer.keptCount in (0, answer.objectCount), "counts do not add up")
        ack = answer.frame if number % 5 != 4 else 0
        client.frames[1] = {f: s for f, s in client.frames[1].items() if f >= ack}
    expect(client.deltas >= len(cameras) // 5, f"only {client.deltas} changes")


async def newest_camera_wins(client, cameras):
    sent = [await client.send(client.update(1, camera_of(cameras[i % len(cameras)])))
            for i in range(100)]
    passed_over = answers = 0
    while True:
        got, name, answer = await client.receive()
        expect(name == "Answer" and got in sent, f"{name} for {got}")
        client.take(answer)
        passed_over += answer.superseded
        answers += 1
        if got == sent[-1]:
            break
    expect(answers + passed_over == len(sent), f"{answers} answers, {passed_over} passed over")


async def edit_and_undo(client, other, camera):
    ids = client.take(await client.ask(client.update(1, camera), "Answer"))
    gone = min(ids)
    hide = make(EditT, expectedVersion=0,
                edits=[make(EditItemT, kind=EditKind.Hide, object=gone, worldFromMesh=[])])
    edited = await client.ask(hide, "Edited")
    without = await client.ask(client.update(1, camera), "Answer")
    expect(client.take(without) == ids - {gone}, "the hidden object is answered")
    expect(without.sceneVersion >= edited.sceneVersion, "the answer is of an older scene")
    hide.expectedVersion = edited.sceneVersion + 1
    await client.refused(hide, WireCode.Conflict)
    await other.ask(make(PingT, timeNs=1), "Pong")  # a notice may be on its way: it comes first or next
    for _ in range(100):
        if other.notices:
            break
        await asyncio.sleep(0.02)
        await other.ask(make(PingT, timeNs=1), "Pong")
    name, notice = other.notices[0]
    expect(name == "SceneChanged" and not notice.replaced and
           notice.scene.version >= edited.sceneVersion, "no word of the change")
    hide.expectedVersion = 0
    hide.edits[0].kind = EditKind.Show
    await client.ask(hide, "Edited")
    expect(client.take(await client.ask(client.update(1, camera), "Answer")) == ids,
           "the object that was shown again is missing")
    row = [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0]
    add = make(EditT, edits=[make(EditItemT, kind=EditKind.Add, object=gone, worldFromMesh=row)])
    added = (await client.ask(add, "Edited")).added
    expect(len(added) == 1, "one object was added")
    remove = make(EditT, edits=[make(EditItemT, kind=EditKind.Remove, object=int(added[0]),
                                     worldFromMesh=[])])
    await client.ask(remove, "Edited")
    await client.refused(remove, WireCode.InvalidEdit)


async def say_wrong_things(client, camera):
    await client.refused(make(OpenViewT, view=2, method="magic"), WireCode.UnknownMethod)
    await client.refused(client.update(9, camera), WireCode.UnknownView)
    await client.refused(make(CloseViewT, view=9), WireCode.UnknownView)
    flat = make(CameraT, lookAt=camera.lookAt, widthPx=0, heightPx=720)
    await client.refused(client.update(1, flat), WireCode.InvalidCamera)
    demand = make(DemandT, holePx=-1.0)
    await client.refused(client.update(1, camera, demand=demand), WireCode.InvalidDemand)
    await client.refused(make(EditT, edits=[]), WireCode.InvalidEdit)
    await client.refused(make(HelloT, protoMin=1, protoMax=1, client="again"), WireCode.BadMessage)
    for nonsense in ("a text", b"no FlatBuffer at all"):
        await client.socket.send(nonsense)
        got, name, error = await client.receive()
        expect((got, name, error.code) == (0, "ErrorReply", WireCode.BadMessage), "garbage is taken")


async def cancel_and_deadlines(client, camera):
    await client.send(make(CancelT, requestId=4711))  # never said: nothing happens
    await client.ask(make(PingT, timeNs=7), "Pong")
    for _ in range(20):
        asked = await client.send(client.update(1, camera))
        await client.send(make(CancelT, requestId=asked))
        got, name, body = await client.receive()
        expect(got == asked, "the reply of another request")
        expect(name == "Answer" or body.code == WireCode.Cancelled, "neither answered nor cancelled")
        if name == "Answer":
            client.take(body)
    for deadline in (1, 1000, 5_000_000):
        asked = await client.send(client.update(1, camera, deadlineUs=deadline))
        got, name, body = await client.receive()
        late = name == "ErrorReply" and body.code == WireCode.DeadlineExceeded
        expect(got == asked and (name == "Answer" or late), "neither answered nor too late")
        expect(not late or deadline < 5_000_000, "five seconds were not enough")
        if name == "Answer":
            client.take(body)


async def converse(port, scene, cameras, truth):
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/v1/scenes/{scene}/objects") as reply:
        nodes = json.load(reply)["nodes"]
    client, other = await connect(port, scene), await connect(port, scene)
    await client.refused(make(PingT, timeNs=1), WireCode.HelloExpected)
    await client.refused(make(HelloT, protoMin=8, protoMax=9, client="future"),
                         WireCode.UnsupportedVersion)
    welcome = await greet(client, scene)
    expect(welcome.scene.objects == len(nodes), "the scene has another number of objects")
    await greet(other, scene)
    opened = await client.ask(make(OpenViewT, view=1, method="frustum", wantSeen=True), "ViewOpened")
    expect((opened.view, opened.method, opened.guarantee) == (1, b"frustum", 0), "another view")
    await follow_cameras(client, cameras, truth, nodes)
    await newest_camera_wins(client, cameras)
    await edit_and_undo(client, other, camera_of(cameras[0]))
    await say_wrong_things(client, camera_of(cameras[0]))
    await cancel_and_deadlines(client, camera_of(cameras[0]))
    pong = await client.ask(make(PingT, timeNs=1 << 63), "Pong")
    expect(pong.timeNs == 1 << 63, "another time")
    await (await client.socket.ping())  # WebSocket's own
    await client.ask(make(CloseViewT, view=1), "ViewClosed")
    await client.refused(client.update(1, camera_of(cameras[0])), WireCode.UnknownView)
    for one in (client, other):
        await one.socket.close(1000, "done")
        expect(one.socket.close_code == 1000, f"closed with {one.socket.close_code}")
    return client


def main():
    port, scene = int(sys.argv[1]), sys.argv[2]
    with open(sys.argv[3], encoding="utf-8") as file:
        cameras = json.load(file)
    with open(sys.argv[4], encoding="utf-8") as file:
        truth = [sorted(frame["visible"]) for frame in json.load(file)["frames"]]
    expect(set_hash([1, 2, 300]) == 0x0F7E2E44E0EFEB6F, "the document's example of a hash")
    client = asyncio.run(converse(port, scene, cameras, truth))
    print(f"{len(cameras)} cameras, {client.deltas} answers as changes, {client.last_id} requests")


if __name__ == "__main__":
    main()
