#include "server/session_log.h"

#include <utility>

namespace culld::server {

SessionLog::SessionLog(std::string peer, std::string scene, StreamSocket::executor_type executor,
                       Context& context)
    : context_(context),
      number_(++context.sessions_begun),
      scene_(std::move(scene)),
      peer_(std::move(peer)),
      burst_(std::move(executor)) {}

void SessionLog::opened() {
  open_ = true;
  opened_ = context_.clock.now();
  context_.log.info("session opened", {{"session", number_}, {"scene", scene_}, {"peer", peer_}});
}

void SessionLog::answered(std::size_t bytes) {
  ++answers_;
  answer_bytes_ += bytes;
}

void SessionLog::refused(protocol::WireCode code) {
  ++refusals_;
  context_.log.info("message refused", {{"session", number_},
                                        {"scene", scene_},
                                        {"peer", peer_},
                                        {"code", protocol::wireCodeName(code)}});
}

void SessionLog::edited() {
  ++edits_;
  if (untold_edits_++ > 0) return;
  burst_.expires_after(std::chrono::seconds(1));
  burst_.async_wait([weak = weak_from_this()](boost::system::error_code failure) {
    const auto self = weak.lock();
    if (self && !failure) self->tellEdits();
  });
}

void SessionLog::tellEdits() {
  const auto edits = std::exchange(untold_edits_, 0);
  if (edits == 0) return;
  context_.log.info("scene edited",
                    {{"session", number_}, {"scene", scene_}, {"peer", peer_}, {"edits", edits}});
}

void SessionLog::closed(const std::string& why) {
  if (!std::exchange(open_, false)) return;
  tellEdits();
  const std::chrono::duration<double> seconds = context_.clock.now() - opened_;
  context_.log.info("session closed", {{"session", number_},
                                       {"scene", scene_},
                                       {"peer", peer_},
                                       {"why", why},
                                       {"seconds", seconds.count()},
                                       {"answers", answers_},
                                       {"answer_bytes", answer_bytes_},
                                       {"received_bytes", received_bytes_},
                                       {"edits", edits_},
                                       {"refusals", refusals_}});
}

}  // namespace culld::server
