// An array in shared, immutable chunks: a changed copy shares every chunk that it did not touch.
#pragma once
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace culld {

template <typename T, std::size_t kChunk = 1024>
class ChunkedArray {
 public:
  static constexpr std::size_t kChunkSize = kChunk;

  std::size_t size() const noexcept { return size_; }
  const T& operator[](std::size_t i) const noexcept { return (*chunks_[i / kChunk])[i % kChunk]; }

  /// Replaces element i in this array only; other copies keep theirs. COST: copies a chunk once.
  /// REQUIRES: i < size(). THREADS: an array that others read is copied first, then changed.
  T& mutableAt(std::size_t i) { return ownedChunk(i / kChunk)[i % kChunk]; }

  void push_back(const T& value) {
    if (size_ % kChunk == 0) {
      auto fresh = std::make_shared<std::vector<T>>();
      chunks_.push_back(std::move(fresh));
    }
    ownedChunk(size_ / kChunk).push_back(value);
    ++size_;
  }

  /// Gives back what growing reserved. REQUIRES: no other copy is being read.
  void shrinkToFit() {
    chunks_.shrink_to_fit();
    for (auto& c : chunks_) c->shrink_to_fit();
  }

  std::size_t chunkCount() const noexcept { return chunks_.size(); }
  const std::vector<T>& chunk(std::size_t c) const noexcept { return *chunks_[c]; }
  bool sharesChunk(std::size_t c, const ChunkedArray& other) const noexcept {
    return c < other.chunks_.size() && chunks_[c] == other.chunks_[c];
  }
  std::size_t bytes() const noexcept {
    std::size_t total = chunks_.capacity() * sizeof(chunks_[0]);
    for (const auto& c : chunks_) total += c->capacity() * sizeof(T);
    return total;
  }

 private:
  std::vector<T>& ownedChunk(std::size_t c) {
    if (chunks_[c].use_count() != 1) {
      auto copy = std::make_shared<std::vector<T>>();
      copy->reserve(kChunk);
      *copy = *chunks_[c];
      chunks_[c] = std::move(copy);
    }
    return *chunks_[c];
  }

  std::vector<std::shared_ptr<std::vector<T>>> chunks_;
  std::size_t size_ = 0;
};

}  // namespace culld
