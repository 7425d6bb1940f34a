"""The blind benchmark: does wheelhop name physics it was not told about?"""
