// What may be called where, and when: from callbacks, from other threads, at the worst moment.
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "culld/connection.h"
#include "tests/unit/client/scripted_server.h"

namespace culld::client {
namespace {

/// Answers so many cameras, then waits for the end.
Script::Play answering(std::uint32_t count) {
  return [count](Peer& peer) {
    peer.greet();
    peer.openView();
    for (std::uint32_t frame = 1; frame <= count; ++frame) {
      peer.send({peer.nextCamera().first, wholeAnswer(frame, {frame})});
    }
    peer.awaitEnd();
  };
}

TEST(Callbacks, MayAskTheNextCamera) {
  Script server(answering(5));
  std::promise<std::thread::id> fifth;
  std::function<void(const Result<FramePtr>&)> next;
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  next = [&](const Result<FramePtr>& frame) {
    ASSERT_TRUE(frame.ok());
    if (frame.value()->number == 5) return fifth.set_value(std::this_thread::get_id());
    EXPECT_EQ(client.view->setCamera({}, {}, next), frame.value()->camera + 1);
  };
  EXPECT_EQ(client.view->setCamera({}, {}, next), 1U);
  auto where = fifth.get_future();
  ASSERT_EQ(where.wait_for(5s), std::future_status::ready);
  EXPECT_NE(where.get(), std::this_thread::get_id());
}

TEST(Callbacks, AreRefusedWhatWouldWaitForItself) {
  Script server(answering(1));
  std::promise<std::vector<Error>> tried;
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  client.view->setCamera({}, {}, [&](const Result<FramePtr>&) {
    tried.set_value({client.view->cull({}).error(), client.connection->openView().error(),
                     client.connection->ping().error(),
                     client.connection->edit({{protocol::EditKind::kHide, 1, {}}}).error()});
  });
  auto errors = tried.get_future();
  ASSERT_EQ(errors.wait_for(1s), std::future_status::ready);  // the limit for replies is 2 s
  for (const Error& error : errors.get()) {
    EXPECT_EQ(error.code, ErrorCode::kInvalidInput);
    EXPECT_NE(error.message.find("would wait for itself"), std::string::npos) << error.message;
  }
}

TEST(Callbacks, TakeEveryKindOfReply) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    const Message edit = peer.next();
    ASSERT_TRUE(std::holds_alternative<protocol::Edit>(edit.body));
    peer.send({edit.id, protocol::Edited{9, {44}}});
    peer.send({peer.next().id, protocol::Pong{1}});
    peer.awaitEnd();
  });
  std::promise<View> opened_view;
  std::promise<Result<EditOutcome>> edited;
  std::promise<bool> pong;
  std::promise<Result<std::unique_ptr<Connection>>> opened;
  Connection::open(server.address(), "town", quick(),
                   [&](Result<std::unique_ptr<Connection>> c) { opened.set_value(std::move(c)); });
  auto connection = opened.get_future().get();
  ASSERT_TRUE(connection.ok()) << connection.error().message;
  connection.value()->openView(
      "raster", false, [&](Result<View> view) { opened_view.set_value(std::move(view).value()); });
  const View view = opened_view.get_future().get();
  EXPECT_EQ(view.method(), "raster");
  connection.value()->edit({{protocol::EditKind::kHide, 1, {}}}, 0,
                           [&](Result<EditOutcome> r) { edited.set_value(std::move(r)); });
  const auto outcome = edited.get_future().get();
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  EXPECT_EQ(outcome.value().added, Ids{44});
  connection.value()->ping(
      [&](const Result<std::chrono::nanoseconds>& time) { pong.set_value(time.ok()); });
  EXPECT_TRUE(pong.get_future().get());
}

TEST(Callbacks, HearOfAFailedOpen) {
  boost::asio::io_context io;
  tcp::acceptor acceptor(io, tcp::endpoint(tcp::v4(), 0));
  const Address address{"127.0.0.1", acceptor.local_endpoint().port(), {}};
  acceptor.close();
  std::promise<Error> failed;
  Connection::open(address, "town", quick(), [&](Result<std::unique_ptr<Connection>> connection) {
    failed.set_value(connection.error());
  });
  EXPECT_EQ(failed.get_future().get().code, ErrorCode::kUnavailable);
}

TEST(Callbacks, MayDestroyTheConnection) {
  Script server(answering(1));
  auto client = std::make_unique<Client>(server.address());
  ASSERT_NE(client->view, nullptr);
  std::promise<void> gone;
  std::atomic<bool> second_failed = false;
  client->view->setCamera({}, {}, [&](const Result<FramePtr>&) {
    client->view->setCamera({}, {},
                            [&](const Result<FramePtr>& frame) { second_failed = !frame.ok(); });
    client.reset();
    gone.set_value();
  });
  ASSERT_EQ(gone.get_future().wait_for(5s), std::future_status::ready);
  EXPECT_TRUE(second_failed);  // what waited was told before the connection was gone
}

TEST(Close, OfAViewTellsItsCameras) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.nextCamera();
    peer.awaitEnd();
  });
  Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  auto waiting = client.view->setCamera({});
  client.view.reset();
  ASSERT_EQ(waiting.wait_for(5s), std::future_status::ready);
  const auto told = waiting.get();
  ASSERT_FALSE(told.ok());
  EXPECT_EQ(told.error().code, ErrorCode::kCancelled);
}

TEST(Close, EndsWaitsOnOtherThreadsAtOnce) {
  std::promise<void> both;
  auto waits = both.get_future();
  Script server([&both](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.next();
    peer.next();
    both.set_value();
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  auto waiting = std::async(std::launch::async, [&] { return client.view->cull({}); });
  auto pinging = std::async(std::launch::async, [&] { return client.connection->ping(); });
  ASSERT_EQ(waits.wait_for(5s), std::future_status::ready);
  const auto start = std::chrono::steady_clock::now();
  client.connection->close();
  EXPECT_FALSE(waiting.get().ok());
  EXPECT_FALSE(pinging.get().ok());
  EXPECT_LT(std::chrono::steady_clock::now() - start, 1s);  // the limit for replies is 2 s
  client.connection->close();
  EXPECT_EQ(client.connection->state(), ConnectionState::kEnded);
  EXPECT_EQ(client.view->cull({}).error().message,
            toString(server.address()) + ": connection closed");
}

TEST(Close, InterruptsTheWaitForTheNextAttempt) {
  ConnectOptions options = quick();
  options.reconnect = {true, 60'000ms, 60'000ms, 2.0, 0.0, 0};
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.cut();
  });
  const auto start = std::chrono::steady_clock::now();
  {
    const Client client(server.address(), options);
    ASSERT_NE(client.view, nullptr);
    while (client.connection->state() == ConnectionState::kConnected) {
      std::this_thread::sleep_for(5ms);
    }
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
}

TEST(Close, DoesNotWaitLongForAServerThatHangs) {
  std::promise<void> done;
  auto may_end = done.get_future();
  Script server([&](Peer& peer) {
    peer.greet();
    peer.openView();
    may_end.wait();  // reads nothing, not even the goodbye
  });
  const auto start = std::chrono::steady_clock::now();
  {
    const Client client(server.address());
    ASSERT_NE(client.view, nullptr);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, 3s);
  done.set_value();
}

TEST(Idle, ASilentServerIsLeftAndTheNextOneAsked) {
  std::promise<void> done;
  auto may_end = done.get_future();
  ConnectOptions options = quick();
  options.timeouts.idle = 300ms;
  options.timeouts.reply = 5000ms;
  options.reconnect = {true, 10ms, 10ms, 2.0, 0.0, 0};
  Script server({[](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.nextCamera();
                   std::this_thread::sleep_for(1s);  // hangs: answers no ping
                 },
                 [&](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.send({peer.nextCamera().first, wholeAnswer(1, {2})});
                   may_end.wait();
                 }});
  const Client client(server.address(), options);
  ASSERT_NE(client.view, nullptr);
  const auto frame = client.view->cull({});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, Ids{2});
  done.set_value();
}

TEST(Threads, MayAllUseOneConnectionWhileItComesAndGoes) {
  constexpr int kConnections = 6;
  std::vector<Script::Play> plays;
  for (int i = 0; i < kConnections; ++i) {
    plays.emplace_back([](Peer& peer) {
      try {
        peer.greet();
        peer.openView();
        for (std::uint32_t frame = 1; frame <= 20; ++frame) {
          peer.send({peer.nextCamera().first, wholeAnswer(frame, {frame})});
        }
      } catch (const std::exception&) {  // the client's end came first
      }
      peer.cut();
    });
  }
  ConnectOptions options = quick();
  options.timeouts.connect = 300ms;
  options.reconnect = {true, 1ms, 2ms, 1.0, 0.5, 3};
  Script server(std::move(plays));
  std::atomic<int> answered = 0;
  const Client client(server.address(), options);
  ASSERT_NE(client.view, nullptr);
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&] {
      while (client.connection->state() != ConnectionState::kEnded) {
        client.view->setCamera({}, {}, [&](const Result<FramePtr>& f) { answered += f.ok(); });
        std::this_thread::sleep_for(1ms);
      }
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_GT(answered, 20);
}

}  // namespace
}  // namespace culld::client
