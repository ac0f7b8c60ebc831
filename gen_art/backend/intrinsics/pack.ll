; `llvm-as pack.ll` writes pack.bc, which kernels link. Taichi hands over where a variable lies, and not its value.
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"

; write those of sixteen words that are marked (by another word than 0) behind `count` others, then add to the count; what
; follows them, up to sixteen words, is written over
define internal void @sixteen(i64 %marks, i64 %words, i64 %to, i32* %count) alwaysinline nounwind {
  %marks.memory = inttoptr i64 %marks to <16 x i32>*
  %words.memory = inttoptr i64 %words to <16 x i32>*
  %mark = load <16 x i32>, <16 x i32>* %marks.memory, align 64
  %word = load <16 x i32>, <16 x i32>* %words.memory, align 64
  %chosen = icmp ne <16 x i32> %mark, zeroinitializer
  %packed = call <16 x i32> @llvm.x86.avx512.mask.compress.v16i32(<16 x i32> %word, <16 x i32> zeroinitializer, <16 x i1> %chosen)
  %before = load i32, i32* %count
  %before.wide = zext i32 %before to i64
  %bytes = shl i64 %before.wide, 2
  %place = add i64 %to, %bytes
  %memory = inttoptr i64 %place to <16 x i32>*
  store <16 x i32> %packed, <16 x i32>* %memory, align 4
  %bits = bitcast <16 x i1> %chosen to i16
  %many = call i16 @llvm.ctpop.i16(i16 %bits)
  %many.wide = zext i16 %many to i32
  %after = add i32 %before, %many.wide
  store i32 %after, i32* %count
  ret void
}

; the same of 32 words
define void @gen_art_pack(i64* %marks.variable, i64* %words.variable, i64* %to.variable, i32* %count) alwaysinline nounwind {
  %marks = load i64, i64* %marks.variable
  %words = load i64, i64* %words.variable
  %to = load i64, i64* %to.variable
  call void @sixteen(i64 %marks, i64 %words, i64 %to, i32* %count)
  %more.marks = add i64 %marks, 64
  %more.words = add i64 %words, 64
  call void @sixteen(i64 %more.marks, i64 %more.words, i64 %to, i32* %count)
  ret void
}

declare <16 x i32> @llvm.x86.avx512.mask.compress.v16i32(<16 x i32>, <16 x i32>, <16 x i1>)
declare i16 @llvm.ctpop.i16(i16)
