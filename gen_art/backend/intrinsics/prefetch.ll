; `llvm-as prefetch.ll` writes prefetch.bc, which kernels link. Taichi hands over where a variable lies, and not its value.
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"

; bring the memory at an address into the second cache, to be read
define void @gen_art_prefetch(i64* %variable) alwaysinline nounwind {
  %address = load i64, i64* %variable
  %memory = inttoptr i64 %address to i8*
  call void @llvm.prefetch.p0i8(i8* %memory, i32 0, i32 2, i32 1)
  ret void
}

declare void @llvm.prefetch.p0i8(i8*, i32, i32, i32)
